// Recorded arm samples into every method of the arm's calibration, and the gimbal's.
#include "palpate/device/arm_samples.h"
#include "fuzz/check.h"
#include "palpate/calibration/arm.h"
#include "palpate/calibration/gimbal.h"

namespace palpate::fuzz {
namespace {

// As many joints as the samples have: a PHANToM for three, else a chain of equal links in turning directions.
device::ArmModel model_for(Eigen::Index joints) {
  device::ArmModel model;
  if (joints == 3) return model;
  model.kind = device::ArmModel::Kind::dh;
  model.name = "chain";
  for (Eigen::Index j = 0; j < joints; ++j)
    model.joints.push_back({0.2, j % 2 == 0 ? 1.5707963 : 0.0, 0.1, 0.0});
  model.tool = {0.0, 0.0, 0.1};
  return model;
}

void hold_arm(const calibration::ArmSolution& arm, const std::vector<device::ArmObservation>& samples) {
  hold_finite(arm.gain, "gains are finite");
  hold_finite(arm.offset, "offsets are finite");
  hold_finite(arm.X_world_base, "the base's pose is rigid");
  hold_finite(arm.tip_in_marker, "a tip is finite");
  for (const auto& error : calibration::arm_errors(arm, samples))
    hold_finite(error, "an arm's errors are finite");
}

}  // namespace

Refusals arm_samples(std::string_view file) {
  constexpr Eigen::Index kMostJoints = 7;
  Refusals refusals;
  const auto read = device::parse_arm_samples(file, "arm.csv");
  if (!answered(read, refusals)) return refusals;
  auto samples = read->observations;
  cut(samples, 24);
  if (samples.front().joints.size() > kMostJoints) return refusals;
  const device::ArmModel model = model_for(samples.front().joints.size());
  const bool markers = samples.front().marker.has_value();
  calibration::ArmOptions options;
  const auto calibrated = [&](calibration::ArmMethod method, const calibration::ArmFree& free) {
    options.method = method;
    options.free = free;
    auto arm = calibration::calibrate_arm(samples, model, options);
    const bool given = answered(arm, refusals);
    if (given) hold_arm(arm->value, samples);
    return given ? std::optional(std::move(*arm)) : std::nullopt;
  };
  calibration::ArmFree free;
  free.tip = false;
  calibrated(calibration::ArmMethod::one_pass, free);
  if (model.kind ==
      device::ArmModel::Kind::phantom)  // with more joints they take seconds under the sanitizers
    for (const auto method : {calibration::ArmMethod::alternating, calibration::ArmMethod::eq7})
      calibrated(method, free);
  free.tip = markers;
  const auto arm = calibrated(calibration::ArmMethod::joint, free);
  if (arm && model.kind == device::ArmModel::Kind::phantom && samples.front().gimbal && markers) {
    const auto gimbal = calibration::calibrate_gimbal(samples, *arm);
    if (answered(gimbal, refusals)) hold_finite(gimbal->value.correction.gain, "gimbal gains are finite");
  }
  free.quadratic = true;
  free.dh = model.kind == device::ArmModel::Kind::dh;
  calibrated(calibration::ArmMethod::joint, free);
  free.hysteresis = free.delay = true;
  if (samples.front().time_s) calibrated(calibration::ArmMethod::joint, free);
  answered(calibration::uncorrected_arm(samples, model, options), refusals);
  return refusals;
}

}  // namespace palpate::fuzz
