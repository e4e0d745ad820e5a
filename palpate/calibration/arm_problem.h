// The least-squares problem behind the arm's calibration: which numbers are free, residuals, derivatives, the
// solver.
//
// Residual of a sample: predicted - measured tip, metres, World. Internal to this module. No thread rule.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/arm.h"

namespace palpate {

struct ArmFreedom {
  bool base = true, gains = false, offsets = false, first_offset = true, lengths = false, alpha = false,
       tool = false, tip = false;
};

// One free number of the solution.
struct ArmParameter {
  enum class Part { base_rotation, base_translation, gain, offset, length, a, d, alpha, tool, tip };
  Part part;
  Eigen::Index index;
  std::string name;
  double size;  // what is plausible, one sigma: SI units; the prior's width (none on the base)
};

std::vector<ArmParameter> list_parameters(const ArmModel& model, const ArmFreedom& freedom);

// The solution with x added to its free numbers; the base turned by exp(x) on the left.
ArmSolution moved(const ArmSolution& at, const std::vector<ArmParameter>& parameters,
                  const Eigen::VectorXd& x);

struct WeighedSample {
  const ArmObservation* observation = nullptr;
  Matrix3 whitening = Matrix3::Identity();  // keeps metres
  double weight = 1.0;
};

// Predicted minus measured; `J` (3 x parameters) holds its derivatives where asked for.
Vector3 arm_residual(const ArmSolution& at, const ArmObservation& sample,
                     const std::vector<ArmParameter>& parameters, Eigen::Matrix3Xd* J);

struct ArmFit {
  ArmSolution solution;
  double cost = 0.0;  // sum of weighted squares, m^2, without the prior
  int iterations = 0;
  bool converged = false;
};

// Levenberg-Marquardt from `start`. `prior_scale` (m) is the noise that weighs the prior about `nominal`; 0 =
// no prior.
ArmFit solve_arm(const std::vector<WeighedSample>& samples, const ArmSolution& start,
                 const std::vector<ArmParameter>& parameters, const ArmSolution& nominal, double prior_scale,
                 int most_iterations = 100);

// The same with the base minimised inside the residual (equations 7 and 8); `parameters` without the base.
ArmFit solve_arm_inside(const std::vector<WeighedSample>& samples, const ArmSolution& start,
                        const std::vector<ArmParameter>& parameters, int most_iterations = 100);

// Base (and tip, and tool, where free) from the present joint correction.
Expected<ArmSolution> place_arm(const std::vector<WeighedSample>& samples, const ArmSolution& at,
                                bool fit_tip, bool fit_tool);

}  // namespace palpate
