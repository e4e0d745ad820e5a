#include "palpate/experiment/psychometric_bootstrap.h"

#include <cmath>
#include <stdexcept>
#include <vector>

#include "palpate/core/random.h"
#include "palpate/core/statistics.h"
#include "palpate/experiment/internal/data_verdict.h"
#include "palpate/experiment/internal/likelihood_search.h"

namespace palpate::experiment {
namespace {

constexpr int kFewestRepeats = 40;

// Counts as the curve would give them.
std::vector<Level> drawn(const PsychometricCurve& curve, const TaskShape& task, std::span<const Level> levels,
                         Random& random) {
  std::vector<Level> all(levels.begin(), levels.end());
  for (auto& level : all) {
    const double chance = chance_at(curve, task, level.stimulus).positive;
    level.positives = 0;
    for (int i = 0; i < level.trials; ++i) level.positives += random.chance(chance) ? 1 : 0;
  }
  return all;
}

Interval percentiles(const std::vector<double>& values, double level, double low_bound, double high_bound) {
  const double tail = 0.5 * (1.0 - level);
  const double low = quantile(values, tail), high = quantile(values, 1.0 - tail);
  return {std::exp(low), std::exp(high), low <= low_bound, high >= high_bound};
}

}  // namespace

Bootstrap bootstrap(const PsychometricFit& fit, std::span<const Level> levels, const TaskShape& task,
                    const BootstrapOptions& options) {
  if (options.repeats < kFewestRepeats)
    throw std::invalid_argument("bootstrap: at least 40 repeats are expected");
  Random random(options.seed, "experiment/bootstrap");
  const auto bounds = bounds_of(levels, task);
  const Parameters fitted{std::log(fit.curve.threshold), std::log(fit.curve.spread), fit.curve.lapse};
  std::vector<double> thresholds, spreads;
  Bootstrap result;
  int as_large = 0;
  for (int i = 0; i < options.repeats; ++i) {
    const auto again = drawn(fit.curve, task, levels, random);
    auto found = search(again, task, bounds, 1);
    if (const auto near = descend(again, task, bounds, fitted, kAllFree); near.deviance < found.deviance)
      found = near;
    thresholds.push_back(found.at[0]);
    spreads.push_back(found.at[1]);
    if (found.deviance >= fit.deviance) ++as_large;
    const bool told = judge_counts(again) == DataVerdict::usable &&
                      judge_curve(again, bounds, found) == DataVerdict::usable;
    if (!told) ++result.without_curve;
  }
  result.threshold = percentiles(thresholds, options.level, bounds.low[0], bounds.high[0]);
  result.spread = percentiles(spreads, options.level, bounds.low[1], bounds.high[1]);
  result.deviance_share = static_cast<double>(as_large) / options.repeats;
  result.repeats = options.repeats;
  return result;
}

}  // namespace palpate::experiment
