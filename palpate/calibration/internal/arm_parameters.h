// The free numbers of an arm's calibration: their names, what is plausible for them, and how they move an
// ArmSolution.
//
// SI and radians. The base's turn is a tangent vector in World axes (left perturbation); all others add.
// Internal to this module and to what plans with it. Pure functions, no thread rule.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/arm.h"

namespace palpate::calibration {

struct ArmFreedom {
  bool base = true, gains = false, offsets = false, first_offset = true, quadratic = false,
       hysteresis = false, delay = false, lengths = false, alpha = false, tool = false, tip = false,
       correction = false;
};

// One free number of the solution.
struct ArmParameter {
  enum class Part {
    base_rotation,
    base_translation,
    gain,
    offset,
    quadratic,
    hysteresis,
    delay,
    length,
    a,
    d,
    alpha,
    tool,
    tip,
    correction
  };
  Part part;
  Eigen::Index index;
  std::string name;
  double size;  // what is plausible, one sigma: SI units; the prior's width (none on the base)

  bool of_base() const { return part == Part::base_rotation || part == Part::base_translation; }
};

std::vector<ArmParameter> list_parameters(const device::ArmModel& model, const ArmFreedom& freedom);

// Those of these names, in their order (Estimate<ArmSolution>::value.parameters).
std::vector<ArmParameter> parameters_named(const device::ArmModel& model,
                                           const std::vector<std::string>& names);

// The number a parameter stands for; not for the base's rotation.
double& number_of(ArmSolution& arm, const ArmParameter& parameter);
double number_of(const ArmSolution& arm, const ArmParameter& parameter);

// The part of x that turns the base.
Vector3 rotation_part(const std::vector<ArmParameter>& parameters, const Eigen::VectorXd& x);

// The solution with x added to its free numbers; the base turned by exp(x) on the left.
ArmSolution moved(const ArmSolution& at, const std::vector<ArmParameter>& parameters,
                  const Eigen::VectorXd& x);

}  // namespace palpate::calibration
