#include "palpate/studies/arm_methods.h"

#include <stdexcept>

namespace palpate {

Expected<Estimate<ArmSolution>> solve_as(std::string_view method, const std::vector<ArmObservation>& samples,
                                         const ArmModel& nominal, const Vector3& tip,
                                         const MethodChoice& choice) {
  ArmOptions options;
  options.tip = tip;
  options.free.gains = choice.free_gains;
  options.allow_field = choice.full_covariance;
  options.free.lengths = choice.lengths == Lengths::free ||
                         (choice.lengths == Lengths::as_the_method_has_them && method != kJoint);
  if (method == kUncorrected) return uncorrected_arm(samples, nominal, options);
  if (method == kOnePass)
    options.method = ArmMethod::one_pass;
  else if (method == kAlternating)
    options.method = ArmMethod::alternating;
  else if (method == kEq7)
    options.method = ArmMethod::eq7;
  else if (method == kJoint)
    options.method = ArmMethod::joint;
  else
    throw std::invalid_argument("study: no method of this name");
  return calibrate_arm(samples, nominal, options);
}

}  // namespace palpate
