#include "palpate/evaluation/studies/internal/arm_methods.h"

#include <stdexcept>

namespace palpate::evaluation::studies {

Expected<Estimate<calibration::ArmSolution>> solve_as(std::string_view method,
                                                      const std::vector<device::ArmObservation>& samples,
                                                      const device::ArmModel& nominal, const Vector3& tip,
                                                      const MethodChoice& choice) {
  calibration::ArmOptions options;
  options.tip = tip;
  options.free.gains = choice.free_gains;
  options.allow_field = choice.full_covariance;
  options.free.lengths = choice.lengths == Lengths::free ||
                         (choice.lengths == Lengths::as_the_method_has_them && method != kJoint);
  if (method == kUncorrected) return calibration::uncorrected_arm(samples, nominal, options);
  if (method == kOnePass)
    options.method = calibration::ArmMethod::one_pass;
  else if (method == kAlternating)
    options.method = calibration::ArmMethod::alternating;
  else if (method == kEq7)
    options.method = calibration::ArmMethod::eq7;
  else if (method == kJoint)
    options.method = calibration::ArmMethod::joint;
  else
    throw std::invalid_argument("study: no method of this name");
  return calibration::calibrate_arm(samples, nominal, options);
}

}  // namespace palpate::evaluation::studies
