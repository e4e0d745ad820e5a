// What a rig keeps of the check that its arm's forces go where they are commanded (palpate calibrate forces).
//
// It holds for one arm, one model of it and one zero of its encoders; void_reason() tells what has changed. N, m, rad,
// ArmBase axes. Values.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "palpate/device/arm_model.h"
#include "palpate/device/joints.h"
#include "palpate/math/so3.h"

namespace palpate::rig {

// N, at the tip: the peak of an arm whose forces nobody has compared with a known weight.
inline constexpr double kUnweighedPeak = 1.0;

// What an arm's kinematics are made of, in one order: of a PHANToM its two lengths; of a chain a, d, alpha and
// theta_offset of each joint and the tool point; of a Cartesian arm its range and its correction. m, rad.
struct ModelNumbers {
  Eigen::VectorXd lengths, angles;
};
ModelNumbers numbers_of(const device::ArmModel& model);

struct ForceCalibration {
  std::string identity;               // of the arm, as its driver tells (device::ArmFacts)
  std::string model;                  // of the arm calibration then, its name
  ModelNumbers model_numbers;         // and its kinematics
  ModelNumbers nominal_numbers;       // the maker's, by which commanded forces become torques
  bool states_place = false;          // a Cartesian arm: its readings and offsets are m
  device::JointVector rest_readings;  // the zero then: as the arm calibration's
  device::JointVector joint_offsets;
  device::JointVector reading_gains;  // of the arm calibration then
  Matrix3 map =
      Matrix3::Identity();          // felt over commanded force, of size 1, in the middle of the poses tried
  Eigen::MatrixXd covariance;       // 9 x 9, of the map row by row; empty where unknown
  Eigen::VectorXd joint_gains;      // torque over commanded torque, beside the median's
  Eigen::VectorXd joint_gains_std;  // empty where unknown
  std::optional<double> gain;       // felt over commanded size, by a known weight
  double gain_std = 0.0;
  double peak = kUnweighedPeak;         // N: at most so much may be commanded
  int dead_man_button = 0;              // of the stylus, counted from 1; 0: none is wanted
  std::string date, method, data_hash;  // as Provenance has them
};

}  // namespace palpate::rig
