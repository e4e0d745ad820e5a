#include "palpate/experiment/internal/data_verdict.h"

#include <algorithm>
#include <cmath>

#include "palpate/math/chi_square.h"

namespace palpate::experiment {
namespace {

// Stimuli whose logarithms differ by less are one: rounding decides what lies between them.
constexpr double kLeastSpan = 1e-9;
// A curve that rises by less than this from the lowest level to the highest says nothing of its shape.
constexpr double kLeastRise = 0.1;
// Where every level lies in the outermost shares of the curve, none is on its slope.
constexpr double kOffTheSlope = 0.005;

// The deviance of one and the same chance at all levels.
double flat_deviance(std::span<const Level> levels) {
  double positives = 0.0, trials = 0.0, sum = 0.0;
  for (const auto& level : levels) {
    positives += level.positives;
    trials += level.trials;
  }
  const auto part = [](double seen, double expected) {
    return seen > 0.0 ? seen * std::log(seen / expected) : 0.0;
  };
  for (const auto& level : levels) {
    const double n = level.trials, k = level.positives, share = positives / trials;
    sum += 2.0 * (part(k, n * share) + part(n - k, n * (1.0 - share)));
  }
  return sum;
}

}  // namespace

DataVerdict judge_counts(std::span<const Level> levels) {
  if (levels.empty()) return DataVerdict::no_trials;
  int positives = 0, trials = 0;
  for (const auto& level : levels) {
    positives += level.positives;
    trials += level.trials;
  }
  if (positives == trials) return DataVerdict::all_positive;
  if (positives == 0) return DataVerdict::all_negative;
  const double span = std::log(levels.back().stimulus) - std::log(levels.front().stimulus);
  return span < kLeastSpan ? DataVerdict::one_level : DataVerdict::usable;
}

DataVerdict judge_curve(std::span<const Level> levels, const SearchBounds& bounds,
                        const SearchResult& found) {
  const auto curve = curve_of(found.at);
  const auto share = [&](const Level& level) {
    return chance_at({curve.threshold, curve.spread, 0.0}, {.guess = 0.0}, level.stimulus).positive;
  };
  const bool rises = share(levels.back()) - share(levels.front()) >= kLeastRise;
  const double gain = flat_deviance(levels) - found.deviance;
  if (!rises || gain < chi_square_quantile(1.0 - kUsualLevel, 1.0, true)) return DataVerdict::no_rise;
  if (found.at[0] <= bounds.low[0] || found.at[0] >= bounds.high[0]) return DataVerdict::out_of_range;
  const bool on_slope = std::any_of(levels.begin(), levels.end(), [&](const Level& level) {
    return share(level) > kOffTheSlope && share(level) < 1.0 - kOffTheSlope;
  });
  return on_slope ? DataVerdict::usable : DataVerdict::separated;
}

}  // namespace palpate::experiment
