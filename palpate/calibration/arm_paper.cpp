// The methods of the 2006 paper, as named baselines: one_pass, alternating, eq7.
#include <cmath>
#include <limits>

#include "palpate/calibration/internal/arm_setting.h"
#include "palpate/calibration/internal/arm_uncertainty.h"

namespace palpate::calibration {
namespace {

constexpr double kAlternatingChange = 1e-4;  // relative, system bar B4
constexpr int kAlternatingRounds = 50, kRoundSteps = 30;
constexpr double kRoundExact = 1e-6;  // of the residuals' length

}  // namespace

Expected<Estimate<ArmSolution>> solve_as_in_the_paper(const ArmSetting& setting, const ArmOptions& options) {
  ArmFreedom freedom = freedom_of(options, setting.nominal.model);
  freedom.base = false;
  const auto parameters = list_parameters(setting.nominal.model, freedom);
  if (const auto fine = enough_samples(setting.samples.size(), parameters.size() + 6); !fine)
    return tl::unexpected(fine.error());
  Estimate<ArmSolution> estimate;
  ArmFit fit;
  if (options.method == ArmMethod::eq7) {
    fit = solve_arm_inside(setting.samples, setting.nominal, parameters);
    estimate.iterations = fit.iterations;
    estimate.termination = fit.converged ? Termination::converged : Termination::iteration_limit;
  } else {
    const int rounds = options.method == ArmMethod::one_pass ? 1 : kAlternatingRounds;
    estimate.termination =
        options.method == ArmMethod::one_pass ? Termination::converged : Termination::iteration_limit;
    fit.solution = setting.nominal;  // its base is the absolute orientation with nominal phi
    double last = std::numeric_limits<double>::infinity();
    for (int round = 0; round < rounds; ++round) {
      if (round > 0) {
        const auto placed = place_arm(setting.samples, fit.solution, false, false);
        if (!placed) return tl::unexpected(placed.error());
        fit.solution = *placed;
      }
      // The rounds stop at a change of 1e-4: what the single solves leave is far below it.
      fit = solve_arm(setting.samples, fit.solution, parameters, setting.nominal, 0.0, kRoundSteps,
                      kRoundExact);
      estimate.iterations = round + 1;
      if (std::abs(last - fit.cost) < kAlternatingChange * fit.cost) {
        estimate.termination = Termination::converged;
        break;
      }
      last = fit.cost;
    }
  }
  estimate.value = std::move(fit.solution);
  freedom.base = true;
  freedom.first_offset = setting.nominal.model.kind != device::ArmModel::Kind::phantom;
  add_arm_covariance(estimate, setting, list_parameters(setting.nominal.model, freedom), false);
  return estimate;
}

}  // namespace palpate::calibration
