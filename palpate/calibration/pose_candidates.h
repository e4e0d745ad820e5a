// Poses of a PHANToM's stylus that a person could be asked for: within the joints' and the gimbal's range,
// marker turned towards the tracker.
//
// World (tracker) frame, SI, radians. Deterministic for a generator's state. One generator, one thread.
#pragma once

#include <array>
#include <vector>

#include "palpate/calibration/arm.h"
#include "palpate/core/random.h"
#include "palpate/core/units.h"

namespace palpate::calibration {

struct ReachablePoses {
  // Readings, as the maker states the range; the Premium 1.5's are the default.
  std::array<std::array<double, 2>, 3> joint_range{
      {{radians_from_degrees(-45.0), radians_from_degrees(45.0)},
       {radians_from_degrees(-10.0), radians_from_degrees(85.0)},
       {radians_from_degrees(-25.0), radians_from_degrees(65.0)}}};
  double largest_fold = radians_from_degrees(80.0);  // theta 2 - theta 3; the singular line is at 90 degrees
  Vector3 tracker = Vector3::Zero();                 // World
  Vector3 marker_normal = Vector3::UnitZ();          // where the LEDs shine, in the marker
  double largest_tilt = radians_from_degrees(37.0);  // of that away from the tracker
  double largest_gimbal = radians_from_degrees(75.0);  // second gimbal angle, where the mount is known
};

// Of a marker's pose, as a tracker gives it: rotation, translation, World axes; and what its stated accuracy
// leaves beyond that, m^2.
struct PoseNoise {
  Matrix6 pose;
  Matrix3 systematic = Matrix3::Zero();
};

// `count` poses: half of all joint values at an end of their range, half of all tilts the largest, the rest
// spread evenly, any roll. `R_tip_marker`: how the marker is mounted on the stylus, where that is known.
// `noise`: what a pose will be measured with.
std::vector<device::ArmObservation> candidate_poses(
    const ArmSolution& arm, const ReachablePoses& reach, int count, Random& random,
    const std::optional<Quaternion>& R_tip_marker = std::nullopt,
    const std::optional<PoseNoise>& noise = std::nullopt);

}  // namespace palpate::calibration
