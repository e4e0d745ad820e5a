#include "palpate/evaluation/studies/internal/arm_laboratory.h"

#include <cmath>

#include "palpate/calibration/pivot.h"
#include "palpate/core/random.h"
#include "palpate/core/units.h"
#include "palpate/sim/pose_sampling.h"
#include "palpate/sim/simulated_arm.h"
#include "palpate/sim/simulated_tracker.h"

namespace palpate::evaluation::studies {
namespace {

constexpr int kAttempts = 200;

tl::unexpected<Error> hidden() {
  return refused(
      "study: the tracker does not see the stylus in {} poses; let it look at the arm's reach (look_at_m, "
      "joint_range_deg of the world file)",
      kAttempts);
}

tl::unexpected<Error> folded() {
  return refused(
      "study: the arm is folded up (joint 2 more than {:.0f} degrees above joint 3) in nearly all of its "
      "range; widen joint_range_deg of the world file",
      degrees_from_radians(sim::SimulatedArm::kFoldLimit));
}

Vector3 readings(const Vector3& theta, const device::JointCorrection& joints,
                 const sim::config::WorldFile& world) {
  Vector3 psi = joints.undo(theta);
  for (double& angle : psi) angle = sim::quantised(angle, world.arm.encoder_quantum);
  return psi;
}

class Bench {
 public:
  Bench(const sim::config::WorldFile& world, std::uint64_t seed, const sim::Truth& truth)
      : world_(world),
        truth_(truth),
        tracker_(world, seed),
        middle_(sim::middle_of_tracker(world)),
        R_base_world_(truth.X_world_base.rotation.conjugate()),
        R_marker_tip_(truth.X_tip_marker.rotation.conjugate()) {}

  struct StillPose {
    device::ArmObservation seen;
    Vector3 theta;
  };

  // One pose that stands still, as tracker and encoders report it.
  Expected<StillPose> pose(Random& random) {
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const auto theta = sim::random_joints(world_, random);
      if (!theta) return folded();
      const Vector3 tip = place_of(*theta);
      const Quaternion marker = turned(tip, sim::kAnyRoll, random);
      const Vector3 gimbal = device::phantom_gimbal(*theta, R_base_world_ * (marker * R_marker_tip_));
      if (std::abs(gimbal[1]) > sim::kGimbalReach) continue;
      const auto seen = look(marker, tip);
      if (!seen.seen) continue;
      device::ArmObservation sample;
      sample.joints = readings(*theta, truth_.joints, world_);
      sample.marker = Pose<World, TipMarker>{seen.rotation, seen.translation};
      // Of the tip as the maker of the stylus states it: this laboratory's own is not known yet.
      sample.covariance = seen.point_covariance(world_.tip_marker.tip);
      sample.systematic = std::sqrt(seen.systematic.trace());
      return StillPose{std::move(sample), *theta};
    }
    return hidden();
  }

  // The marker swung about the tip, which the arm holds and the hand drags.
  Expected<calibration::PivotPose> swing(Random& random) {
    const Vector3 held = place_of(sim::middle_joints(world_));
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const Quaternion marker = turned(held, sim::kSwingRoll, random);
      const double pull = random.uniform(world_.hand.pull[0], world_.hand.pull[1]);
      const Vector3 dragged =
          pull / world_.hand.fixation_stiffness * sim::pull_direction(marker * R_marker_tip_);
      const auto seen = look(marker, held + dragged);
      if (seen.seen) return calibration::PivotPose{seen.rotation, seen.translation, 0, {}};
    }
    return hidden();
  }

 private:
  Vector3 place_of(const Vector3& theta) const {
    return (truth_.X_world_base * device::phantom_tip(theta, truth_.lengths)).m;
  }

  Quaternion turned(const Vector3& tip, double roll, Random& random) const {
    return sim::random_orientation(sim::tip_marker_normal(), (middle_ - tip).normalized(), roll, random);
  }

  device::TrackerSample look(const Quaternion& marker, const Vector3& tip) {
    return tracker_.measure({}, {device::MarkerId::tip_marker, &world_.tip_marker.leds,
                                 sim::tip_marker_normal(), marker, tip - marker * truth_.tip_in_marker});
  }

  const sim::config::WorldFile& world_;
  const sim::Truth& truth_;
  sim::SimulatedTracker tracker_;
  Vector3 middle_;
  Quaternion R_base_world_, R_marker_tip_;
};

}  // namespace

Expected<ArmLaboratory> record_laboratory(const sim::config::WorldFile& world, std::uint64_t seed,
                                          const LaboratorySettings& settings) {
  ArmLaboratory laboratory;
  laboratory.truth = sim::draw_truth(world, seed);
  Bench bench(world, seed, laboratory.truth);
  Random poses(seed, "study/poses"), swings(seed, "study/pivot"), judged(seed, "study/judged");
  for (int i = 0; i < settings.samples + settings.unused; ++i) {
    auto still = bench.pose(poses);
    if (!still) return tl::unexpected(still.error());
    const bool sample = i < settings.samples;
    (sample ? laboratory.samples : laboratory.unused).push_back(std::move(still->seen));
    (sample ? laboratory.sample_theta : laboratory.unused_theta).push_back(still->theta);
  }
  std::vector<calibration::PivotPose> swing;
  for (int i = 0; i < settings.swing; ++i) {
    const auto pose = bench.swing(swings);
    if (!pose) return tl::unexpected(pose.error());
    swing.push_back(*pose);
  }
  laboratory.pivot_tip = world.tip_marker.tip;
  if (!swing.empty()) {
    const auto pivot = calibration::calibrate_pivot(swing);
    if (!pivot) return tl::unexpected(pivot.error());
    laboratory.pivot_tip = pivot->value.tip;
  }
  for (int i = 0; i < settings.judged; ++i) {
    const auto theta = sim::random_joints(world, judged);
    if (!theta) return folded();
    const auto& truth = laboratory.truth;
    laboratory.judged.push_back(truth.joints.undo(*theta));
    laboratory.judged_place.push_back((truth.X_world_base * device::phantom_tip(*theta, truth.lengths)).m);
  }
  return laboratory;
}

ArmLaboratory with_reset(ArmLaboratory laboratory, const sim::config::WorldFile& world,
                         const Vector3& zeros) {
  auto& joints = laboratory.truth.joints;
  const device::JointCorrection before = joints;
  joints.offset += zeros;
  for (std::size_t i = 0; i < laboratory.samples.size(); ++i)
    laboratory.samples[i].joints = readings(laboratory.sample_theta[i], joints, world);
  for (std::size_t i = 0; i < laboratory.unused.size(); ++i)
    laboratory.unused[i].joints = readings(laboratory.unused_theta[i], joints, world);
  for (auto& psi : laboratory.judged) psi = joints.undo(before.apply(psi));
  return laboratory;
}

sim::config::WorldFile white_world(sim::config::WorldFile world) {
  world.tracker.white_rms = metres_from_mm(0.2);
  world.tracker.bias_rms = 0.0;
  return world;
}

device::ArmModel nominal_model(const sim::config::WorldFile& world) {
  return {.lengths = {world.arm.lengths[0], world.arm.lengths[1]}};
}

calibration::ArmSolution true_solution(const ArmLaboratory& laboratory) {
  const auto& truth = laboratory.truth;
  calibration::ArmSolution arm;
  arm.model.lengths = truth.lengths;
  arm.gain = truth.joints.gain;
  arm.offset = truth.joints.offset;
  arm.X_world_base = truth.X_world_base;
  arm.tip_in_marker = truth.tip_in_marker;
  arm.tip_known = true;
  return arm;
}

std::vector<double> errors_to_truth(const calibration::ArmSolution& arm, const ArmLaboratory& laboratory) {
  std::vector<double> errors;
  errors.reserve(laboratory.judged.size());
  const device::JointCorrection joints{arm.gain, arm.offset};
  const Matrix3 R = arm.X_world_base.matrix();
  for (std::size_t i = 0; i < laboratory.judged.size(); ++i) {
    const Vector3 believed =
        R * device::phantom_tip(joints.apply(laboratory.judged[i]), arm.model.lengths).m +
        arm.X_world_base.translation;
    errors.push_back((believed - laboratory.judged_place[i]).norm());
  }
  return errors;
}

std::vector<BoundSample> bound_samples(const std::vector<device::ArmObservation>& samples) {
  std::vector<BoundSample> result;
  for (const auto& sample : samples)
    result.push_back({Vector3(sample.joints), sample.marker->rotation, *sample.covariance});
  return result;
}

}  // namespace palpate::evaluation::studies
