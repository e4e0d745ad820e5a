#include "palpate/calibration/internal/arm_setting.h"

#include <algorithm>
#include <cmath>

#include "palpate/core/text.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

Expected<void> check_arm_samples(const std::vector<device::ArmObservation>& samples,
                                 const device::ArmModel& model, const ArmOptions& options) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto& s = samples[i];
    if (s.joints.size() != model.joint_count())
      return wrong_use(
          "arm: sample {} has {} joint readings, {} has {} joints; joint_1_deg to joint_{}_deg are expected",
          i + 1, s.joints.size(), model.name, model.joint_count(), model.joint_count());
    if (!s.joints.allFinite() || (s.tip && !s.tip->m.allFinite()) ||
        (s.marker && !(s.marker->translation.allFinite() && s.marker->rotation.coeffs().allFinite())))
      return refused("arm: sample {} is not finite; remove it", i + 1);
    if (!s.tip && !s.marker)
      return wrong_use("arm: sample {} has neither a measured tip nor a marker pose", i + 1);
  }
  if ((options.free.quadratic || options.free.hysteresis || options.free.delay) &&
      options.method != ArmMethod::joint)
    return wrong_use(
        "arm: quadratic, hysteresis and delay are estimated by the joint method alone; the methods of the "
        "paper know gains, offsets and lengths");
  if ((options.free.hysteresis || options.free.delay) && !all_have_times(samples))
    return wrong_use("arm: hysteresis and delay need the time of each sample (time_s), some have none");
  if (options.free.delay && !taken_in_motion(samples))
    return refused(
        "arm: the delay shows in motion only, and most samples are more than {:.0f} ms apart; record while "
        "the stylus moves, at 20 Hz or faster",
        1e3 * kMotionGap);
  if (model.kind == device::ArmModel::Kind::cartesian && options.method != ArmMethod::joint)
    return wrong_use(
        "arm: {} states its place, not its joints; the methods of the paper correct joints, use the joint "
        "method",
        model.name);
  if (options.free.dh && model.kind != device::ArmModel::Kind::dh)
    return wrong_use("arm: {} has no Denavit-Hartenberg rows to free; use lengths", model.name);
  return {};
}

bool all_have_markers(const std::vector<device::ArmObservation>& samples) {
  return std::all_of(samples.begin(), samples.end(), [](const auto& s) { return s.marker.has_value(); });
}

bool all_have_tips(const std::vector<device::ArmObservation>& samples) {
  return std::all_of(samples.begin(), samples.end(), [](const auto& s) { return s.tip.has_value(); });
}

// The base's turn shows in places of the tip that do not lie on a line.
Expected<void> check_spread(const ArmSetting& setting) {
  constexpr double kLeastWidth = 1e-3;  // m rms, across the line
  Vector3 mean = Vector3::Zero();
  std::vector<Vector3> tips;
  for (const auto& sample : setting.samples) {
    tips.push_back(device::arm_tip(setting.nominal.model, joint_angles(setting.nominal, sample.motion)).m);
    mean += tips.back() / static_cast<double>(setting.samples.size());
  }
  Matrix3 scatter = Matrix3::Zero();
  for (const auto& tip : tips)
    scatter += (tip - mean) * (tip - mean).transpose() / static_cast<double>(tips.size());
  const double width = std::sqrt(std::max(0.0, symmetric_eigenvalues(scatter)[1]));
  if (width >= kLeastWidth) return {};
  return refused(
      "arm: the tip moves along one line only ({:.2f} mm rms across it, {:.0f} mm are needed), so how the "
      "base is turned cannot be known; move the arm through its workspace",
      1e3 * width, 1e3 * kLeastWidth);
}

ArmSolution nominal_arm(const device::ArmModel& model, const ArmFree& free) {
  ArmSolution arm;
  arm.model = model;
  arm.gain = Eigen::VectorXd::Ones(model.joint_count());
  arm.offset = Eigen::VectorXd::Zero(model.joint_count());
  if (free.quadratic) arm.quadratic = Eigen::VectorXd::Zero(model.joint_count());
  if (free.hysteresis) arm.hysteresis = Eigen::VectorXd::Zero(model.joint_count());
  return arm;
}

}  // namespace

void take_motion(ArmSetting& setting, double delay_s) {
  auto motions = arm_motions(*setting.recording, delay_s);
  for (std::size_t k = 0; k < setting.samples.size(); ++k)
    setting.samples[k].motion = std::move(motions[setting.used[k]]);
}

Expected<ArmSetting> prepare_arm(const std::vector<device::ArmObservation>& observations,
                                 const device::ArmModel& model, const ArmOptions& options,
                                 const std::vector<bool>& used) {
  if (!used.empty() && used.size() != observations.size())
    return wrong_use("arm: {} marks for {} samples", used.size(), observations.size());
  if (const auto fine = check_arm_samples(observations, model, options); !fine)
    return tl::unexpected(fine.error());
  ArmSetting setting;
  const bool markers = all_have_markers(observations), tips = all_have_tips(observations);
  const bool wants_tip = options.method == ArmMethod::joint && options.free.tip && markers;
  setting.tip_free = wants_tip;
  if (!tips && !markers)
    return wrong_use("arm: some samples have a marker pose, others a measured tip; give one kind");
  setting.nominal = nominal_arm(model, options.free);
  const bool use_markers = markers && (wants_tip || options.tip || !tips);
  if (use_markers) {
    setting.nominal.tip_known = true;
    setting.tip_found = !options.tip;
    if (options.tip) setting.nominal.tip_in_marker = *options.tip;
  }
  double mean_variance = 0.0;
  setting.recording = &observations;
  for (std::size_t i = 0; i < observations.size(); ++i)
    if (used.empty() || used[i]) setting.used.push_back(i);
  const std::size_t needed = 6;
  if (setting.used.size() < needed)
    return refused("arm: {}; at least {} are needed", counted(setting.used.size(), "sample"), needed);
  const double count = static_cast<double>(setting.used.size());
  double systematic = 0.0;
  for (const std::size_t i : setting.used) {
    const device::ArmObservation& o = observations[i];
    WeighedSample sample{&o, {}, Matrix3::Identity(), 1.0};
    if (o.covariance && options.method == ArmMethod::joint) {
      if (!whitening(*o.covariance, sample.whitening))
        return wrong_use("arm: the covariance of sample {} is not positive definite", i + 1);
      mean_variance += o.covariance->trace() / 3.0 / count;
    }
    if (o.systematic) systematic += *o.systematic * *o.systematic / 3.0 / count;
    setting.samples.push_back(sample);
  }
  setting.stated_variance = mean_variance;
  if (mean_variance > 0.0 && observations.front().systematic)
    setting.stated_share = std::min(1.0, systematic / mean_variance);
  for (auto& sample : setting.samples)  // back to metres, so that scales stay readable
    if (sample.observation->covariance && options.method == ArmMethod::joint)
      sample.whitening *= std::sqrt(mean_variance);
  take_motion(setting, 0.0);
  const auto placed = place_arm(setting.samples, setting.nominal, setting.tip_found,
                                model.kind == device::ArmModel::Kind::dh && !model.tool_known);
  if (!placed) return tl::unexpected(placed.error());
  setting.nominal = *placed;
  if (const auto fine = check_spread(setting); !fine) return tl::unexpected(fine.error());
  return setting;
}

ArmFreedom freedom_of(const ArmOptions& options, const device::ArmModel& model) {
  ArmFreedom freedom;
  const bool joint = options.method == ArmMethod::joint;
  const bool dh = model.kind == device::ArmModel::Kind::dh;
  freedom.base = true;
  if (model.kind == device::ArmModel::Kind::cartesian) {
    freedom.correction = options.free.correction;
    freedom.delay = joint && options.free.delay;
    return freedom;
  }
  freedom.gains = options.free.gains || options.free.dh;
  freedom.offsets = options.free.offsets || options.free.dh;
  freedom.lengths = options.free.lengths || options.free.dh;
  freedom.alpha = options.free.dh;
  freedom.quadratic = joint && options.free.quadratic;
  freedom.hysteresis = joint && options.free.hysteresis;
  freedom.delay = joint && options.free.delay;
  freedom.tool = dh && !model.tool_known;
  return freedom;
}

Expected<void> enough_samples(std::size_t samples, std::size_t parameters) {
  const std::size_t needed = (parameters + 2) / 3 + 1;
  if (samples < needed)
    return refused("arm: {} for {} unknowns; at least {} are needed, spread over the workspace",
                   counted(samples, "sample"), parameters, needed);
  return {};
}

}  // namespace palpate::calibration
