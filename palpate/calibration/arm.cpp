#include "palpate/calibration/arm.h"

#include "palpate/calibration/internal/arm_setting.h"

namespace palpate::calibration {

Point<World> predict_tip(const ArmSolution& arm, const Eigen::VectorXd& psi) {
  return arm.X_world_base * device::arm_tip(arm.model, joint_angles(arm, {psi, {}, {}}));
}

Point<World> measured_tip(const ArmSolution& arm, const device::ArmObservation& sample) {
  if (by_marker(arm, sample)) return *sample.marker * Point<TipMarker>{arm.tip_in_marker};
  return *sample.tip;
}

std::vector<Vector3> arm_errors(const ArmSolution& arm, const std::vector<device::ArmObservation>& samples) {
  std::vector<Vector3> errors;
  errors.reserve(samples.size());
  const auto motions = arm_motions(samples, arm.delay_s);
  std::vector<WeighedSample> whole(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) whole[i] = {&samples[i], motions[i]};
  const Eigen::VectorXd r = whitened_residuals(whole, arm);  // unit whitening: as they are
  for (std::size_t i = 0; i < samples.size(); ++i)
    errors.push_back(-r.segment<3>(3 * static_cast<Eigen::Index>(i)));
  return errors;
}

Expected<Estimate<ArmSolution>> calibrate_arm(const std::vector<device::ArmObservation>& samples,
                                              const device::ArmModel& model, const ArmOptions& options,
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

Expected<Estimate<ArmSolution>> uncorrected_arm(const std::vector<device::ArmObservation>& samples,
                                                const device::ArmModel& model, const ArmOptions& options) {
  ArmOptions plain = options;
  plain.free = {
      .gains = false, .offsets = false, .lengths = false, .tip = options.free.tip, .correction = false};
  const auto setting = prepare_arm(samples, model, plain);
  if (!setting) return tl::unexpected(setting.error());
  Estimate<ArmSolution> estimate;
  estimate.value = setting->nominal;
  estimate.residuals = arm_errors(estimate.value, samples);
  return estimate;
}

}  // namespace palpate::calibration
