#include "palpate/calibration/arm.h"

#include "palpate/calibration/arm_setting.h"

namespace palpate {

Point<World> predict_tip(const ArmSolution& arm, const Eigen::VectorXd& psi) {
  return arm.X_world_base * arm_tip(arm.model, joint_angles(arm, {psi, {}, {}}));
}

Point<World> measured_tip(const ArmSolution& arm, const ArmObservation& sample) {
  if (by_marker(arm, sample)) return *sample.marker * Point<TipMarker>{arm.tip_in_marker};
  return *sample.tip;
}

std::vector<Vector3> arm_errors(const ArmSolution& arm, const std::vector<ArmObservation>& samples) {
  std::vector<Vector3> errors;
  errors.reserve(samples.size());
  if (arm.delay_s == 0.0 && arm.hysteresis.size() == 0) {
    for (const auto& sample : samples)
      errors.push_back((measured_tip(arm, sample) - predict_tip(arm, sample.joints)).v);
    return errors;
  }
  const auto motions = arm_motions(samples, arm.delay_s);
  for (std::size_t i = 0; i < samples.size(); ++i)
    errors.push_back(-arm_residual(arm, samples[i], motions[i], {}, nullptr));
  return errors;
}

Expected<Estimate<ArmSolution>> calibrate_arm(const std::vector<ArmObservation>& samples,
                                              const ArmModel& model, const ArmOptions& options,
                                              const std::vector<bool>& used) {
  auto setting = prepare_arm(samples, model, options, used);
  if (!setting) return tl::unexpected(setting.error());
  auto estimate = options.method == ArmMethod::joint ? solve_joint(std::move(*setting), options)
                                                     : solve_as_in_the_paper(*setting, options);
  if (!estimate) return estimate;
  estimate->residuals = arm_errors(estimate->value, samples);
  if (!used.empty() && !estimate->inlier.empty()) {
    std::vector<bool> of_all(samples.size(), false);
    for (std::size_t i = 0, k = 0; i < samples.size(); ++i)
      if (used[i]) of_all[i] = estimate->inlier[k++];
    estimate->inlier = std::move(of_all);
  }
  return estimate;
}

Expected<Estimate<ArmSolution>> uncorrected_arm(const std::vector<ArmObservation>& samples,
                                                const ArmModel& model, const ArmOptions& options) {
  ArmOptions plain = options;
  plain.free = {.gains = false, .offsets = false, .lengths = false, .tip = options.free.tip};
  const auto setting = prepare_arm(samples, model, plain);
  if (!setting) return tl::unexpected(setting.error());
  Estimate<ArmSolution> estimate;
  estimate.value = setting->nominal;
  estimate.residuals = arm_errors(estimate.value, samples);
  return estimate;
}

}  // namespace palpate
