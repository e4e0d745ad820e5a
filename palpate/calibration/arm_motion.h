// What the encoders read at the moment a tracker's sample belongs to, how fast they turned, and from which
// side they came.
//
// A recording's rows carry readings and a measurement that the tracker stamped alike; the tracker's stamps
// may lag by a constant delay, so the readings that belong to the measurement of row i are those at time_i -
// delay. Between rows the readings follow cubic Hermite pieces (tangents of the parabola through three rows);
// where rows are further apart than kMotionGap the arm is taken to be at rest in each. Rows may come in any
// order. Radians, rad/s. Pure functions, no thread rule.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "palpate/device/arm_samples.h"

namespace palpate::calibration {

// Rows further apart were not taken in one motion, s.
inline constexpr double kMotionGap = 0.1;

struct ArmMotion {
  Eigen::VectorXd joints;     // psi, rad
  Eigen::VectorXd rate;       // rad/s; zero at rest; empty without times
  Eigen::VectorXd direction;  // -1, 0, +1: how each joint moved last; 0 where unknown; empty without times
};

// One per row, in the rows' order.
std::vector<ArmMotion> arm_motions(const std::vector<device::ArmObservation>& samples, double delay_s = 0.0);

// The rows with joints and gimbal as they were `delay_s` before.
std::vector<device::ArmObservation> with_delay_removed(const std::vector<device::ArmObservation>& samples,
                                                       double delay_s);

bool all_have_times(const std::vector<device::ArmObservation>& samples);

// Whether most rows were taken in motion: neighbours in time are closer than kMotionGap.
bool taken_in_motion(const std::vector<device::ArmObservation>& samples);

}  // namespace palpate::calibration
