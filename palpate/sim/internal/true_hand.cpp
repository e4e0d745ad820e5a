#include "palpate/sim/internal/true_hand.h"

#include "palpate/render/hand_shape.h"

namespace palpate::sim {
namespace {

// Of a right hand that holds the handle like a pen between thumb, index and middle finger; frame as hand_shape.h.
const render::HandCapsule kBones[] = {
    // index finger: tip, middle and first bone
    {{-0.002, 0.014, 0.040}, {0.003, 0.020, 0.062}, 0.0075, 0.0085},
    {{0.003, 0.020, 0.062}, {0.010, 0.004, 0.088}, 0.0085, 0.0095},
    {{0.010, 0.004, 0.088}, {0.022, -0.028, 0.104}, 0.0100, 0.0120},
    // thumb
    {{-0.014, -0.004, 0.046}, {-0.018, -0.020, 0.072}, 0.0090, 0.0105},
    {{-0.018, -0.020, 0.072}, {-0.004, -0.056, 0.092}, 0.0115, 0.0170},
    // middle finger, below the handle
    {{0.006, -0.014, 0.038}, {0.017, -0.016, 0.064}, 0.0078, 0.0088},
    {{0.017, -0.016, 0.064}, {0.026, -0.032, 0.092}, 0.0090, 0.0100},
    // ring and little finger, curled
    {{0.008, -0.030, 0.052}, {0.028, -0.030, 0.070}, 0.0078, 0.0088},
    {{0.028, -0.030, 0.070}, {0.034, -0.046, 0.094}, 0.0090, 0.0095},
    {{0.012, -0.044, 0.060}, {0.032, -0.046, 0.074}, 0.0070, 0.0080},
    {{0.032, -0.046, 0.074}, {0.038, -0.060, 0.094}, 0.0080, 0.0090},
    // palm: four bones side by side
    {{0.018, -0.024, 0.098}, {0.012, -0.076, 0.106}, 0.0140, 0.0150},
    {{0.024, -0.030, 0.096}, {0.020, -0.078, 0.104}, 0.0140, 0.0150},
    {{0.032, -0.040, 0.094}, {0.028, -0.080, 0.102}, 0.0130, 0.0150},
    {{0.038, -0.050, 0.090}, {0.036, -0.082, 0.100}, 0.0120, 0.0140},
    // wrist and forearm
    {{0.026, -0.078, 0.104}, {0.036, -0.110, 0.112}, 0.0270, 0.0260},
    {{0.036, -0.110, 0.112}, {0.070, -0.330, 0.165}, 0.0265, 0.0410}};

}  // namespace

std::vector<render::ArmPart> true_hand_parts(const TrueHand& hand, int segments) {
  std::vector<render::ArmPart> parts;
  if (hand.side == device::HoldingHand::none) return parts;
  const Quaternion roll(Eigen::AngleAxisd(hand.roll, Vector3::UnitZ()));
  const auto placed = [&](Vector3 p) {
    if (hand.side == device::HoldingHand::left) p.x() *= -1.0;
    return Vector3(roll * (hand.size * p) + hand.along * Vector3::UnitZ());
  };
  for (const render::HandCapsule& bone : kBones)
    parts.push_back({render::capsule_mesh({placed(bone.a), placed(bone.b), hand.size * bone.radius_a,
                                           hand.size * bone.radius_b},
                                          segments),
                     render::ArmFrame::stylus, render::ArmLook::skin});
  return parts;
}

}  // namespace palpate::sim
