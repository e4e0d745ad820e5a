// One explanation of how a hand gave way to commanded forces, fitted: which joint (or axis) does another's work, with
// which gains, and what hand that leaves. Model and priors: force_check.h. Pure functions.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "palpate/calibration/force_check.h"

namespace palpate::calibration {

// What was measured in one pose.
struct PoseCompliance {
  Eigen::Matrix3Xd jacobian;
  Matrix3 A = Matrix3::Zero();          // m/N
  Vector3 deviation = Vector3::Zero();  // m/N, of each component of column j
};

struct ForceExplanation {
  bool of_joints = true;   // else of ArmBase axes
  std::vector<int> order;  // joint i does what was commanded of joint order[i]
};

struct ForceFit {
  ForceExplanation explanation;
  Eigen::VectorXd gains;       // m/N: of the motors times the hand's compliance
  Eigen::MatrixXd covariance;  // of gains
  Eigen::VectorXd noise;       // deviation of each gain were the hand known: all that its sign hangs on
  Matrix3 hand = Matrix3::Identity();  // its compliance beside its geometric mean, common to all poses
  double cost = 0.0;
};

// Felt over commanded force in a pose, for gains of 1 of joint (or axis) i alone.
Matrix3 felt_map(const ForceExplanation& explanation, const Eigen::Matrix3Xd& jacobian, int i);

ForceFit fit_forces(std::span<const PoseCompliance> poses, const ForceExplanation& explanation,
                    const ForceCheckSettings& settings);

}  // namespace palpate::calibration
