#include "palpate/render/hand_shape.h"

#include <cmath>
#include <numbers>

namespace palpate::render {
namespace {

// Of a right hand: x to the right of who looks along the stylus to its tip, with +y up.
const HandCapsule kRightHand[] = {
    {{-0.004, 0.002, 0.043}, {0.004, -0.012, 0.080}, 0.022, 0.028},   // fingertips and fingers
    {{0.006, -0.020, 0.084}, {0.024, -0.070, 0.101}, 0.029, 0.033},   // the back of the hand
    {{0.024, -0.072, 0.102}, {0.074, -0.352, 0.171}, 0.033, 0.050}};  // wrist and forearm

}  // namespace

// Rings of a ball at each end, joined by a cone.
scene::TriangleMesh capsule_mesh(const HandCapsule& c, int segments) {
  const Vector3 z = (c.b - c.a).normalized(), x = z.unitOrthogonal(), y = z.cross(x);
  const int half = segments / 4, rings = 2 * half;  // of each half ball; of both
  scene::TriangleMesh mesh;
  const auto n = static_cast<std::uint32_t>(segments);
  mesh.vertices.push_back(c.a - c.radius_a * z);
  for (int i = 1; i <= rings; ++i) {
    const bool first = i <= half;
    // The equator is there twice, once of each ball.
    const double angle = 0.5 * std::numbers::pi * (first ? i : i - 1) / half;
    const Vector3& centre = first ? c.a : c.b;
    const double radius = first ? c.radius_a : c.radius_b;
    for (std::uint32_t k = 0; k < n; ++k) {
      const double around = 2.0 * std::numbers::pi * k / n;
      mesh.vertices.push_back(centre - radius * std::cos(angle) * z +
                              radius * std::sin(angle) * (std::cos(around) * x + std::sin(around) * y));
    }
  }
  mesh.vertices.push_back(c.b + c.radius_b * z);
  const auto last = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t next = (k + 1) % n;
    mesh.triangles.push_back({0, 1 + next, 1 + k});
    for (std::uint32_t i = 0; i + 1 < static_cast<std::uint32_t>(rings); ++i) {
      const std::uint32_t a = 1 + i * n + k, b = 1 + i * n + next;
      mesh.triangles.push_back({a, b, b + n});
      mesh.triangles.push_back({a, b + n, a + n});
    }
    mesh.triangles.push_back({last, last - n + k, last - n + next});
  }
  return mesh;
}

std::vector<ArmPart> coarse_hand_parts(device::HoldingHand hand) {
  std::vector<ArmPart> parts;
  if (hand == device::HoldingHand::none) return parts;
  for (HandCapsule capsule : kRightHand) {
    if (hand == device::HoldingHand::left) capsule.a.x() *= -1.0, capsule.b.x() *= -1.0;
    parts.push_back({capsule_mesh(capsule), ArmFrame::stylus, ArmLook::skin});
  }
  return parts;
}

}  // namespace palpate::render
