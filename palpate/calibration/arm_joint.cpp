// The joint solve: every free number at once, robust, from the start that fits best.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/calibration/internal/arm_setting.h"
#include "palpate/calibration/internal/arm_uncertainty.h"
#include "palpate/calibration/noise/robust_scale.h"

namespace palpate::calibration {
namespace {

// Where an encoder zero may be when the arm was reset in an odd position, rad (40 deg): starts for offsets 2
// and 3.
constexpr double kResetStart = 0.7;
// A fit that leaves less than this share of the points' spread is not in a wrong basin, which leaves
// centimetres.
constexpr double kGoodFit = 0.01;
// Delays tried as starts, s.
constexpr double kLongestDelay = 0.24, kDelayStep = 0.02;
constexpr std::size_t kDelayStartSamples = 80;

constexpr int kHuberRounds = 4, kFewestRounds = 6, kMostRounds = 40;
// Residuals within so many scales of a plain fit: nobody would be weighed down in the end.
constexpr double kNoOutlier = 4.5;
constexpr int kStepsPerRound = 1;  // the weights move meanwhile: solving to the end would be for nothing
constexpr int kLastRounds = 10, kLastSteps = 20;
constexpr double kExact = 1e-5;          // of the residuals' length, before the last step
constexpr double kDelaySettled = 1e-10;  // s
// A start need not be solved to the end: steps that change the residuals by less than this share of their
// length are left to what follows.
constexpr double kNear = 1e-3;

// Lengths of the samples' whitened residuals.
std::vector<double> misfits(const std::vector<WeighedSample>& samples, const ArmSolution& arm) {
  const Eigen::VectorXd r = whitened_residuals(samples, arm);
  std::vector<double> lengths(samples.size());
  for (std::size_t i = 0; i < lengths.size(); ++i)
    lengths[i] = r.segment<3>(3 * static_cast<Eigen::Index>(i)).norm();
  return lengths;
}

double spread_of(const std::vector<WeighedSample>& samples, const ArmSolution& arm) {
  Vector3 mean = Vector3::Zero();
  double square = 0.0;
  const double n = static_cast<double>(samples.size());
  for (const auto& s : samples) mean += measured_tip(arm, *s.observation).m / n;
  for (const auto& s : samples) square += (measured_tip(arm, *s.observation).m - mean).squaredNorm() / n;
  return std::sqrt(square);
}

// The best of several starts of a PHANToM's offsets 2 and 3: encoders that were zeroed in an odd position.
ArmSolution best_start(const ArmSetting& setting, const std::vector<ArmParameter>& parameters) {
  const auto nominal =
      solve_arm(setting.samples, setting.nominal, parameters, setting.nominal, 1e-3, 30, kNear);
  const double left =
      noise::robust_scale(misfits(setting.samples, nominal.solution), static_cast<double>(parameters.size()));
  if (left < kGoodFit * spread_of(setting.samples, nominal.solution)) return nominal.solution;
  struct Candidate {
    ArmSolution arm;
    double cost;
  };
  std::vector<Candidate> candidates;
  for (double second : {0.0, -kResetStart, kResetStart}) {
    for (double third : {0.0, -kResetStart, kResetStart}) {
      if (second == 0.0 && third == 0.0) continue;
      ArmSolution start = setting.nominal;
      start.offset[1] = second;
      start.offset[2] = third;
      const auto placed = place_arm(setting.samples, start, setting.tip_found, false);
      if (!placed) continue;
      candidates.push_back({*placed, solve_arm(setting.samples, *placed, {}, setting.nominal, 0.0).cost});
    }
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.cost < b.cost; });
  Candidate best{nominal.solution, nominal.cost};
  for (std::size_t i = 0; i < std::min<std::size_t>(4, candidates.size()); ++i) {
    const auto fit =
        solve_arm(setting.samples, candidates[i].arm, parameters, setting.nominal, 1e-3, 30, kNear);
    // a later start must be clearly better: equal basins keep the nominal one
    if (fit.cost < 0.99 * best.cost) best = {fit.solution, fit.cost};
  }
  return best.arm;
}

// The delay near which the search begins: that of the least cost with everything else fitted.
double first_delay(ArmSetting setting, const std::vector<ArmParameter>& parameters) {
  std::vector<ArmParameter> others;
  for (const auto& parameter : parameters)
    if (parameter.part != ArmParameter::Part::delay) others.push_back(parameter);
  const std::size_t stride = setting.samples.size() / kDelayStartSamples + 1;
  double best = 0.0, least = std::numeric_limits<double>::infinity();
  for (double delay = -kLongestDelay; delay <= kLongestDelay + 1e-9; delay += kDelayStep) {
    take_motion(setting, delay);
    std::vector<WeighedSample> some;
    for (std::size_t i = 0; i < setting.samples.size(); i += stride) some.push_back(setting.samples[i]);
    const auto fit = solve_arm(some, setting.nominal, others, setting.nominal, 1e-3, 5);
    if (fit.cost < least) {
      least = fit.cost;
      best = delay;
    }
  }
  return best;
}

double rms_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

// A joint solution on its way: what it is found from, and how far it has come.
struct JointFit {
  ArmSetting setting;
  ArmFreedom freedom;
  std::vector<ArmParameter> parameters;
  ArmSolution nominal;  // what the prior holds to
  ArmSolution arm;      // so far
  double scale = 1e-3;  // m, of the misfits; replaced by their own

  double unknowns() const { return static_cast<double>(parameters.size()); }
};

// Rounds of solving and weighing anew, until neither misfits nor their scale change.
void weigh_until_settled(JointFit& fit, bool robust, Estimate<ArmSolution>& estimate) {
  std::vector<double> last_lengths(fit.setting.samples.size(), 0.0);
  for (int round = 0; round < kMostRounds; ++round) {
    if (fit.freedom.delay) take_motion(fit.setting, fit.arm.delay_s);
    const auto found =
        solve_arm(fit.setting.samples, fit.arm, fit.parameters, fit.nominal, fit.scale, kStepsPerRound);
    const double delay_before = fit.arm.delay_s;
    fit.arm = found.solution;
    estimate.iterations += found.iterations;
    if (fit.freedom.delay) take_motion(fit.setting, fit.arm.delay_s);
    const double last_scale = fit.scale;
    const auto lengths = misfits(fit.setting.samples, fit.arm);
    fit.scale = noise::robust_scale(lengths, fit.unknowns());
    // What the data do not see may creep for long; the misfits tell whether what they do see stands still.
    const double change =
        rms_difference(lengths, last_lengths) + 0.2 * std::abs(fit.arm.delay_s - delay_before);  // at 0.2 m/s
    last_lengths = lengths;
    if (robust)
      for (std::size_t i = 0; i < lengths.size(); ++i)
        fit.setting.samples[i].weight = round < kHuberRounds ? noise::huber_weight(lengths[i], fit.scale)
                                                             : noise::tukey_weight(lengths[i], fit.scale);
    estimate.termination = Termination::iteration_limit;
    if (round + 1 >= kFewestRounds && (change < 1e-9 || change < 1e-4 * fit.scale) &&
        std::abs(fit.scale - last_scale) < 1e-3 * fit.scale + 2 * noise::kLeastScale) {
      estimate.termination = Termination::converged;
      return;
    }
  }
}

// The weights have told who belongs; those that do now count alike, which wastes nothing of what they say.
Expected<void> keep_inliers(JointFit& fit, Estimate<ArmSolution>& estimate) {
  std::size_t inliers = 0;
  for (auto& sample : fit.setting.samples) {
    const bool inlier = sample.weight > 0.0;
    estimate.inlier.push_back(inlier);
    sample.weight = inlier ? 1.0 : 0.0;
    inliers += inlier;
  }
  if (const auto fine = enough_samples(inliers, fit.parameters.size()); !fine)
    return refused(
        "arm: only {} of {} samples agree with one model of the arm ({} unknowns); check units and joint "
        "order",
        inliers, fit.setting.samples.size(), fit.parameters.size());
  return {};
}

void solve_with_inliers(JointFit& fit, Estimate<ArmSolution>& estimate) {
  for (int round = 0; round < kLastRounds; ++round) {
    if (fit.freedom.delay) take_motion(fit.setting, fit.arm.delay_s);
    const auto found =
        solve_arm(fit.setting.samples, fit.arm, fit.parameters, fit.nominal, fit.scale, kLastSteps, kExact);
    estimate.iterations += found.iterations;
    const double delay_moved = std::abs(found.solution.delay_s - fit.arm.delay_s);
    fit.arm = found.solution;
    const double last_scale = fit.scale;
    fit.scale =
        noise::robust_scale(misfits(fit.setting.samples, fit.arm), fit.unknowns());  // it weighs the prior
    if (delay_moved < kDelaySettled &&
        std::abs(fit.scale - last_scale) < 1e-2 * fit.scale + 2 * noise::kLeastScale)
      return;
  }
}

}  // namespace

Expected<Estimate<ArmSolution>> solve_joint(ArmSetting setting, const ArmOptions& options) {
  const device::ArmModel& model = setting.nominal.model;
  const bool phantom = model.kind == device::ArmModel::Kind::phantom;
  JointFit fit;
  fit.freedom = freedom_of(options, model);
  fit.freedom.first_offset = !phantom;
  fit.freedom.tip = setting.tip_free;
  fit.parameters = list_parameters(model, fit.freedom);
  if (const auto fine = enough_samples(setting.samples.size(), fit.parameters.size()); !fine)
    return tl::unexpected(fine.error());
  if (fit.freedom.delay) {
    setting.nominal.delay_s =
        options.delay_start ? *options.delay_start : first_delay(setting, fit.parameters);
    take_motion(setting, setting.nominal.delay_s);
  }
  fit.nominal = setting.nominal;
  fit.nominal.delay_s = 0.0;
  fit.arm = phantom && options.free.offsets
                ? best_start(setting, fit.parameters)
                : solve_arm(setting.samples, setting.nominal, fit.parameters, fit.nominal, 1e-3).solution;
  fit.setting = std::move(setting);

  Estimate<ArmSolution> estimate;
  bool weigh = fit.freedom.delay;
  if (!weigh) {
    const auto lengths = misfits(fit.setting.samples, fit.arm);
    fit.scale = noise::robust_scale(lengths, fit.unknowns());
    weigh = options.robust && *std::max_element(lengths.begin(), lengths.end()) > kNoOutlier * fit.scale;
    estimate.termination = Termination::converged;
  }
  if (weigh) weigh_until_settled(fit, options.robust, estimate);
  if (auto kept = keep_inliers(fit, estimate); !kept) return tl::unexpected(kept.error());
  solve_with_inliers(fit, estimate);
  estimate.value = std::move(fit.arm);
  add_arm_covariance(estimate, fit.setting, fit.parameters, options.allow_field);
  return estimate;
}

}  // namespace palpate::calibration
