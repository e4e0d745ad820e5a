// Arm model files, where such an arm's tip is, and its calibration from samples it would have given.
#include "fuzz/check.h"
#include "palpate/calibration/arm.h"
#include "palpate/core/random.h"

namespace palpate::fuzz {
namespace {

std::vector<device::ArmObservation> samples_of(const device::ArmModel& model) {
  Random random(1, "fuzz/arm models");
  std::vector<device::ArmObservation> samples(20);
  for (auto& sample : samples) {
    sample.joints.resize(model.joint_count());
    for (auto& angle : sample.joints) angle = random.uniform(-1.0, 1.0);
    const Vector3 noise(random.normal(), random.normal(), random.normal());
    sample.tip = Point<World>{device::arm_tip(model, sample.joints).m + 1e-4 * noise};
  }
  return samples;
}

}  // namespace

Refusals arm_models(std::string_view file) {
  constexpr Eigen::Index kMostJoints = 7;
  Refusals refusals;
  const auto model = device::parse_arm_model(file, "arm.toml");
  if (!answered(model, refusals)) return refusals;
  device::ArmJacobian jacobian;
  const auto tip = device::arm_tip(*model, Eigen::VectorXd::Constant(model->joint_count(), 0.3), jacobian);
  hold_finite(tip.m, "a tip is finite");
  hold_finite(jacobian.theta, "a Jacobian is finite");
  if (model->joint_count() > kMostJoints) return refusals;
  const auto samples = samples_of(*model);
  calibration::ArmOptions options;
  options.free.tip = false;
  for (const bool dh : {false, model->kind == device::ArmModel::Kind::dh}) {
    options.free.dh = dh;
    const auto arm = calibration::calibrate_arm(samples, *model, options);
    if (answered(arm, refusals)) hold_finite(arm->value.X_world_base, "the base's pose is rigid");
  }
  return refusals;
}

}  // namespace palpate::fuzz
