// The least-squares problem behind the arm's calibration: residuals, derivatives, the solves.
//
// Residual of a sample: predicted - measured tip, metres, World. Internal to this module and to what plans
// with it. No thread rule.
#pragma once

#include <vector>

#include "palpate/calibration/arm.h"
#include "palpate/calibration/arm_motion.h"
#include "palpate/calibration/internal/arm_parameters.h"

namespace palpate::calibration {

struct WeighedSample {
  const device::ArmObservation* observation = nullptr;
  ArmMotion motion;                         // readings at the measurement's moment, for the present delay
  Matrix3 whitening = Matrix3::Identity();  // keeps metres
  double weight = 1.0;
};

// Whether a sample's measured tip is told by its marker's pose.
inline bool by_marker(const ArmSolution& arm, const device::ArmObservation& sample) {
  return sample.marker && (arm.tip_known || !sample.tip);
}

// Corrected joint angles.
Eigen::VectorXd joint_angles(const ArmSolution& arm, const ArmMotion& motion);

// Predicted minus measured; `J` (3 x parameters) holds its derivatives where asked for.
Vector3 arm_residual(const ArmSolution& at, const device::ArmObservation& sample, const ArmMotion& motion,
                     const std::vector<ArmParameter>& parameters, Eigen::Matrix3Xd* J);
// Of a sample taken at rest.
Vector3 arm_residual(const ArmSolution& at, const device::ArmObservation& sample,
                     const std::vector<ArmParameter>& parameters, Eigen::Matrix3Xd* J);
// The whitened residuals of all samples, one below the other, with their derivatives (3n x parameters) where
// `J` is given; weights do not matter.
Eigen::VectorXd whitened_residuals(const std::vector<WeighedSample>& samples, const ArmSolution& at,
                                   const std::vector<ArmParameter>& parameters = {},
                                   Eigen::MatrixXd* J = nullptr);
// Derivatives of the predicted tip alone.
void predicted_tip_derivatives(const ArmSolution& at, const ArmMotion& motion,
                               const std::vector<ArmParameter>& parameters, Eigen::Matrix3Xd& J);

struct ArmFit {
  ArmSolution solution;
  double cost = 0.0;  // sum of weighted squares, m^2, without the prior
  int iterations = 0;
  bool converged = false;
};

// Levenberg-Marquardt from `start`. `prior_scale` (m) is the noise that weighs the prior about `nominal`; 0 =
// no prior. The delay moves linearly about the samples' motion: call again with the motion taken anew.
ArmFit solve_arm(const std::vector<WeighedSample>& samples, const ArmSolution& start,
                 const std::vector<ArmParameter>& parameters, const ArmSolution& nominal, double prior_scale,
                 int most_iterations = 100, double tolerance = 1e-10);

// The same with the base minimised inside the residual (equations 7 and 8); `parameters` without the base.
ArmFit solve_arm_inside(const std::vector<WeighedSample>& samples, const ArmSolution& start,
                        const std::vector<ArmParameter>& parameters, int most_iterations = 100);

// Base (and tip, and tool, where free) from the present joint correction.
Expected<ArmSolution> place_arm(const std::vector<WeighedSample>& samples, const ArmSolution& at,
                                bool fit_tip, bool fit_tool);

}  // namespace palpate::calibration
