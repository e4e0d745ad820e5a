#include "palpate/studies/arm_laboratory.h"

#include <cmath>
#include <numbers>

#include "palpate/calibration/pivot.h"
#include "palpate/core/random.h"
#include "palpate/core/units.h"
#include "palpate/sim/tracker_twin.h"

namespace palpate {
namespace {

const double kCone = radians_from_degrees(40.0);  // tilt of the marker away from the tracker
const double kRollSwing = radians_from_degrees(60.0);
const double kGimbalLimit = radians_from_degrees(75.0);  // second gimbal angle a person uses
constexpr double kFoldLimit = 1.45;                      // rad, largest t2 - t3: where the arm folds up
constexpr double kAlongStylus = 0.85, kDownwards = 0.5;  // how a swinging hand's pull splits
constexpr int kAttempts = 200;

double quantised(double value, double quantum) {
  return quantum > 0.0 ? quantum * std::round(value / quantum) : value;
}

Vector3 random_joints(const sim::WorldFile& world, Random& random) {
  for (;;) {
    Vector3 theta;
    for (int i = 0; i < 3; ++i) {
      const auto& [low, high] = world.arm.joint_range[static_cast<std::size_t>(i)];
      theta[i] = random.uniform(low, high);
    }
    if (theta[1] - theta[2] <= kFoldLimit) return theta;
  }
}

class Bench {
 public:
  Bench(const sim::WorldFile& world, std::uint64_t seed, const sim::Truth& truth)
      : world_(world), truth_(truth), tracker_(world, seed), random_(seed, "study/poses") {
    for (const auto& camera : world.tracker.cameras) middle_ += camera / 3.0;
  }

  // One pose that stands still, as tracker and encoders report it.
  Expected<ArmObservation> pose() {
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const Vector3 theta = random_joints(world_, random_);
      const Vector3 tip = (truth_.X_world_base * phantom_tip(theta, truth_.lengths)).m;
      const Quaternion marker = turned(tip, kCone, std::numbers::pi);
      const Quaternion stylus = marker * truth_.X_tip_marker.rotation.conjugate();
      const Vector3 gimbal = phantom_gimbal(theta, truth_.X_world_base.rotation.conjugate() * stylus);
      if (std::abs(gimbal[1]) > kGimbalLimit) continue;
      const auto seen = look(marker, tip);
      if (!seen.seen) continue;
      ArmObservation sample;
      Vector3 psi = truth_.joints.undo(theta);
      for (double& angle : psi) angle = quantised(angle, world_.arm.encoder_quantum);
      sample.joints = psi;
      sample.marker = Pose<World, TipMarker>{seen.rotation, seen.translation};
      // Of the tip as the maker of the stylus states it: this laboratory's own is not known yet.
      Eigen::Matrix<double, 3, 6> J;
      J << -hat(seen.rotation * world_.tip_marker.tip), Matrix3::Identity();
      sample.covariance = J * seen.covariance * J.transpose();
      return sample;
    }
    return hidden();
  }

  // The marker swung about the tip, which the arm holds and the hand drags.
  Expected<PivotPose> swing() {
    Vector3 middle;
    for (int i = 0; i < 3; ++i) {
      const auto& [low, high] = world_.arm.joint_range[static_cast<std::size_t>(i)];
      middle[i] = 0.5 * (low + high);
    }
    const Vector3 held = (truth_.X_world_base * phantom_tip(middle, truth_.lengths)).m;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const Quaternion marker = turned(held, kCone, kRollSwing);
      const Quaternion stylus = marker * truth_.X_tip_marker.rotation.conjugate();
      const Vector3 pull =
          random_.uniform(world_.hand.pull[0], world_.hand.pull[1]) *
          (kAlongStylus * (stylus * Vector3::UnitZ()) - kDownwards * Vector3::UnitY()).normalized();
      const auto seen = look(marker, held + pull / world_.hand.fixation_stiffness);
      if (seen.seen) return PivotPose{seen.rotation, seen.translation, 0, {}};
    }
    return hidden();
  }

  Vector3 judged() { return truth_.joints.undo(random_joints(world_, random_)); }

 private:
  // Faces the tracker up to a tilt, uniform over the cap, and a roll.
  Quaternion turned(const Vector3& tip, double cone, double roll) {
    const Vector3 towards = (middle_ - tip).normalized();
    const double tilt = std::acos(random_.uniform(std::cos(cone), 1.0));
    const double around = random_.uniform(0.0, 2.0 * std::numbers::pi);
    const Vector3 side = towards.unitOrthogonal();
    const Vector3 axis = std::cos(around) * side + std::sin(around) * towards.cross(side);
    const Quaternion facing = Quaternion::FromTwoVectors(sim::tip_marker_normal(), towards);
    const double rolled = random_.uniform(-roll, roll);
    return (Quaternion(Eigen::AngleAxisd(tilt, axis)) * Quaternion(Eigen::AngleAxisd(rolled, towards)) *
            facing)
        .normalized();
  }

  TrackerSample look(const Quaternion& marker, const Vector3& tip) {
    return tracker_.measure({}, {MarkerId::tip_marker, &world_.tip_marker.leds, sim::tip_marker_normal(),
                                 marker, tip - marker * truth_.tip_in_marker});
  }

  static tl::unexpected<Error> hidden() {
    return refused("study: the tracker does not see the stylus in {} poses; let it look at the arm's reach",
                   kAttempts);
  }

  const sim::WorldFile& world_;
  const sim::Truth& truth_;
  sim::TrackerTwin tracker_;
  Random random_;
  Vector3 middle_ = Vector3::Zero();
};

}  // namespace

Expected<ArmLaboratory> record_laboratory(const sim::WorldFile& world, std::uint64_t seed,
                                          const LaboratorySettings& settings) {
  ArmLaboratory laboratory;
  laboratory.truth = sim::draw_truth(world, seed);
  laboratory.truth.joints.offset += settings.reset;
  Bench bench(world, seed, laboratory.truth);
  for (int i = 0; i < settings.samples + settings.unused; ++i) {
    auto sample = bench.pose();
    if (!sample) return tl::unexpected(sample.error());
    (i < settings.samples ? laboratory.samples : laboratory.unused).push_back(std::move(*sample));
  }
  std::vector<PivotPose> swing;
  for (int i = 0; i < settings.swing; ++i) {
    const auto pose = bench.swing();
    if (!pose) return tl::unexpected(pose.error());
    swing.push_back(*pose);
  }
  const auto pivot = calibrate_pivot(swing);
  if (!pivot) return tl::unexpected(pivot.error());
  laboratory.pivot_tip = pivot->value.tip;
  for (int i = 0; i < settings.judged; ++i) laboratory.judged.push_back(bench.judged());
  return laboratory;
}

sim::WorldFile white_world(sim::WorldFile world) {
  world.tracker.white_rms = metres_from_mm(0.2);
  world.tracker.bias_rms = 0.0;
  return world;
}

ArmModel nominal_model(const sim::WorldFile& world) {
  return {.lengths = {world.arm.lengths[0], world.arm.lengths[1]}};
}

std::vector<double> errors_to_truth(const ArmSolution& arm, const ArmLaboratory& laboratory) {
  std::vector<double> errors;
  errors.reserve(laboratory.judged.size());
  const auto& truth = laboratory.truth;
  const JointCorrection joints{arm.gain, arm.offset};
  for (const auto& psi : laboratory.judged) {
    const Vector3 real = (truth.X_world_base * phantom_tip(truth.joints.apply(psi), truth.lengths)).m;
    const Vector3 believed = (arm.X_world_base * phantom_tip(joints.apply(psi), arm.model.lengths)).m;
    errors.push_back((believed - real).norm());
  }
  return errors;
}

std::vector<BoundSample> bound_samples(const std::vector<ArmObservation>& samples) {
  std::vector<BoundSample> result;
  for (const auto& sample : samples)
    result.push_back({Vector3(sample.joints), sample.marker->rotation, *sample.covariance});
  return result;
}

}  // namespace palpate
