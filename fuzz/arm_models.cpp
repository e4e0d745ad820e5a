// Arm model files, and where such an arm's tip is.
#include "fuzz/check.h"
#include "palpate/model/arm_model.h"

namespace palpate::fuzz {

Refusals arm_models(std::string_view file) {
  Refusals refusals;
  const auto model = parse_arm_model(file, "arm.toml");
  if (!answered(model, refusals)) return refusals;
  ArmJacobian jacobian;
  const auto tip = arm_tip(*model, Eigen::VectorXd::Constant(model->joint_count(), 0.3), jacobian);
  hold_finite(tip.m, "a tip is finite");
  hold_finite(jacobian.theta, "a Jacobian is finite");
  return refusals;
}

}  // namespace palpate::fuzz
