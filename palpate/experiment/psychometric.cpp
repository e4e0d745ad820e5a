#include "palpate/experiment/psychometric.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/experiment/normal.h"

namespace palpate::experiment {
namespace {

// n times ln(n / expected), with its limit at no answer.
double part_of_deviance(double seen, double expected) {
  if (seen == 0.0) return 0.0;
  if (!(expected > 0.0)) return std::numeric_limits<double>::infinity();
  return seen * std::log(seen / expected);
}

constexpr double kThreeOfFour = 0.75;

}  // namespace

std::vector<Level> levels_of(std::span<const Observation> observations) {
  std::vector<Level> levels;
  std::vector<Observation> sorted(observations.begin(), observations.end());
  std::sort(sorted.begin(), sorted.end(),
            [](const auto& a, const auto& b) { return a.stimulus < b.stimulus; });
  for (const auto& one : sorted) {
    if (levels.empty() || levels.back().stimulus != one.stimulus) levels.push_back({one.stimulus, 0, 0});
    levels.back().positives += one.positive ? 1 : 0;
    ++levels.back().trials;
  }
  return levels;
}

Chance chance_at(const PsychometricCurve& curve, const TaskShape& task, double stimulus) {
  const double z = std::log(stimulus / curve.threshold) / curve.spread;
  const double above = normal_below(z), below = normal_below(-z);
  const double guess = task.rule == GuessRule::fixed ? task.guess : curve.lapse;
  return {guess * below + (1.0 - curve.lapse) * above, (1.0 - guess) * below + curve.lapse * above};
}

double stimulus_at(const PsychometricCurve& curve, const TaskShape& task, double share) {
  const double guess = task.rule == GuessRule::fixed ? task.guess : curve.lapse;
  const double part = (share - guess) / (1.0 - guess - curve.lapse);
  if (!(part > 0.0 && part < 1.0)) return std::numeric_limits<double>::quiet_NaN();
  return curve.threshold * std::exp(curve.spread * normal_quantile(part));
}

double deviance(const PsychometricCurve& curve, const TaskShape& task, std::span<const Level> levels) {
  double sum = 0.0;
  for (const auto& level : levels) {
    const auto chance = chance_at(curve, task, level.stimulus);
    const double n = level.trials, k = level.positives;
    sum += 2.0 * (part_of_deviance(k, n * chance.positive) + part_of_deviance(n - k, n * chance.negative));
  }
  return sum;
}

double weber_fraction(double spread) { return std::expm1(spread * normal_quantile(kThreeOfFour)); }

double spread_of_weber_fraction(double fraction) {
  return std::log1p(fraction) / normal_quantile(kThreeOfFour);
}

}  // namespace palpate::experiment
