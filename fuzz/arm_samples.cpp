// Recorded arm samples into every method of the arm's calibration, and the gimbal's.
#include "palpate/model/arm_samples.h"
#include "fuzz/check.h"
#include "palpate/calibration/arm.h"
#include "palpate/calibration/gimbal.h"

namespace palpate::fuzz {
namespace {

// As many joints as the samples have: a PHANToM for three, else a chain of equal links in turning directions.
ArmModel model_for(Eigen::Index joints) {
  ArmModel model;
  if (joints == 3) return model;
  model.kind = ArmModel::Kind::dh;
  model.name = "chain";
  for (Eigen::Index j = 0; j < joints; ++j)
    model.joints.push_back({0.2, j % 2 == 0 ? 1.5707963 : 0.0, 0.1, 0.0});
  model.tool = {0.0, 0.0, 0.1};
  return model;
}

void hold_arm(const ArmSolution& arm, const std::vector<ArmObservation>& samples) {
  hold_finite(arm.gain, "gains are finite");
  hold_finite(arm.offset, "offsets are finite");
  hold_finite(arm.X_world_base, "the base's pose is rigid");
  hold_finite(arm.tip_in_marker, "a tip is finite");
  for (const auto& error : arm_errors(arm, samples)) hold_finite(error, "an arm's errors are finite");
}

}  // namespace

Refusals arm_samples(std::string_view file) {
  constexpr Eigen::Index kMostJoints = 7;
  Refusals refusals;
  const auto read = parse_arm_samples(file, "arm.csv");
  if (!answered(read, refusals)) return refusals;
  auto samples = read->observations;
  cut(samples, 24);
  if (samples.front().joints.size() > kMostJoints) return refusals;
  const ArmModel model = model_for(samples.front().joints.size());
  const bool markers = samples.front().marker.has_value();
  ArmOptions options;
  const auto calibrated = [&](ArmMethod method, const ArmFree& free) {
    options.method = method;
    options.free = free;
    auto arm = calibrate_arm(samples, model, options);
    const bool given = answered(arm, refusals);
    if (given) hold_arm(arm->value, samples);
    return given ? std::optional(std::move(*arm)) : std::nullopt;
  };
  ArmFree free;
  free.tip = false;
  calibrated(ArmMethod::one_pass, free);
  if (model.kind == ArmModel::Kind::phantom)  // with more joints they take seconds under the sanitizers
    for (const auto method : {ArmMethod::alternating, ArmMethod::eq7}) calibrated(method, free);
  free.tip = markers;
  const auto arm = calibrated(ArmMethod::joint, free);
  if (arm && model.kind == ArmModel::Kind::phantom && samples.front().gimbal && markers) {
    const auto gimbal = calibrate_gimbal(samples, *arm);
    if (answered(gimbal, refusals)) hold_finite(gimbal->value.correction.gain, "gimbal gains are finite");
  }
  free.quadratic = true;
  free.dh = model.kind == ArmModel::Kind::dh;
  calibrated(ArmMethod::joint, free);
  free.hysteresis = free.delay = true;
  if (samples.front().time_s) calibrated(ArmMethod::joint, free);
  answered(uncorrected_arm(samples, model, options), refusals);
  return refusals;
}

}  // namespace palpate::fuzz
