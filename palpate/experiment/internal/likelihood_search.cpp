#include "palpate/experiment/internal/likelihood_search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "palpate/experiment/normal.h"
#include "palpate/math/levenberg_marquardt.h"

namespace palpate::experiment {
namespace {

constexpr double kWidestSpread = 10.0;  // over the levels' span
// Of the residuals' length: some 1e-5 of a parameter's deviation, as scoring closes in by a constant factor a step.
constexpr double kTolerance = 1e-7;
constexpr double kSmallestGap = 1e-5;      // over the levels' span
constexpr double kNarrowestSpread = 0.02;  // over the smallest gap between levels

// d p / d (ln threshold, ln spread, lapse).
Parameters derivative_at(const Parameters& at, const TaskShape& task, double stimulus) {
  const double spread = std::exp(at[1]), lapse = at[2];
  const double z = (std::log(stimulus) - at[0]) / spread, density = normal_density(z);
  const bool fixed = task.rule == GuessRule::fixed;
  const double room = fixed ? 1.0 - task.guess - lapse : 1.0 - 2.0 * lapse;
  return {-room * density / spread, -room * density * z,
          fixed ? -normal_below(z) : normal_below(-z) - normal_below(z)};
}

// The deviance has the form of a sum of squares whose normal equations are Fisher's information and the score.
void add_level(const Parameters& at, const TaskShape& task, const Level& level,
               NormalEquations<3>& equations) {
  const auto chance = chance_at(curve_of(at), task, level.stimulus);
  const double variance = chance.positive * chance.negative;
  if (!(variance > 0.0)) return;
  const Parameters slope = derivative_at(at, task, level.stimulus);
  const double surplus =
      level.positives * chance.negative - (level.trials - level.positives) * chance.positive;
  // Far out on the curve's tails both are next to nothing, and only their ratio is a number of ordinary size.
  const Parameters ratio = slope / variance;
  equations.JtJ.noalias() += level.trials * ratio * slope.transpose();
  equations.Jtr.noalias() -= surplus * ratio;
}

void hold(NormalEquations<3>& equations, Eigen::Index i) {
  equations.JtJ.row(i).setZero();
  equations.JtJ.col(i).setZero();
  equations.Jtr[i] = 0.0;
}

}  // namespace

PsychometricCurve curve_of(const Parameters& at) { return {std::exp(at[0]), std::exp(at[1]), at[2]}; }

SearchBounds bounds_of(std::span<const Level> levels, const TaskShape& task) {
  std::vector<double> logs;
  for (const auto& level : levels) logs.push_back(std::log(level.stimulus));
  std::sort(logs.begin(), logs.end());
  const double span = logs.back() - logs.front();
  double gap = span;
  for (std::size_t i = 1; i < logs.size(); ++i) gap = std::min(gap, logs[i] - logs[i - 1]);
  gap = std::max(gap, kSmallestGap * span);
  return {{logs.front() - span, std::log(kNarrowestSpread * gap), 0.0},
          {logs.back() + span, std::log(kWidestSpread * span), task.most_lapse}};
}

SearchResult descend(std::span<const Level> levels, const TaskShape& task, const SearchBounds& bounds,
                     const Parameters& start, const std::array<bool, 3>& free) {
  const auto evaluate = [&](const Parameters& at, NormalEquations<3>* equations) {
    if (equations) {
      for (const auto& level : levels) add_level(at, task, level, *equations);
      for (Eigen::Index i = 0; i < 3; ++i) {
        const bool outwards = (at[i] <= bounds.low[i] && equations->Jtr[i] > 0.0) ||
                              (at[i] >= bounds.high[i] && equations->Jtr[i] < 0.0);
        if (!free[static_cast<std::size_t>(i)] || outwards) hold(*equations, i);
      }
    }
    return deviance(curve_of(at), task, levels);
  };
  const auto moved = [&](const Parameters& at, const Parameters& step) -> Parameters {
    return (at + step).cwiseMax(bounds.low).cwiseMin(bounds.high);
  };
  SearchResult found;
  found.at = start;
  found.deviance = minimise<3>(found.at, evaluate, moved, {.tolerance = kTolerance}).cost;
  return found;
}

Eigen::Matrix3d information_at(std::span<const Level> levels, const TaskShape& task, const Parameters& at) {
  NormalEquations<3> there(3);
  for (const auto& level : levels) add_level(at, task, level, there);
  if (task.most_lapse == 0.0) hold(there, 2);
  return there.JtJ.selfadjointView<Eigen::Lower>();
}

SearchResult search(std::span<const Level> levels, const TaskShape& task, const SearchBounds& bounds,
                    std::size_t descents) {
  constexpr int kPlaces = 7;
  constexpr std::array kSpreads{0.03, 0.1, 0.3, 1.0};  // over the levels' span
  constexpr double kLapse = 0.02;
  const double span = (bounds.high[0] - bounds.low[0]) / 3.0;
  struct Start {
    double deviance;
    Parameters at;
  };
  std::vector<Start> starts;
  for (int i = 0; i < kPlaces; ++i)
    for (const double spread : kSpreads) {
      Parameters at{bounds.low[0] + span * (1.0 + i / (kPlaces - 1.0)), std::log(spread * span),
                    std::min(kLapse, 0.5 * task.most_lapse)};
      at = at.cwiseMax(bounds.low).cwiseMin(bounds.high);
      if (const double cost = deviance(curve_of(at), task, levels); std::isfinite(cost))
        starts.push_back({cost, at});
    }
  std::sort(starts.begin(), starts.end(),
            [](const Start& a, const Start& b) { return a.deviance < b.deviance; });
  SearchResult best;
  best.at = starts.empty() ? Parameters(0.5 * (bounds.low + bounds.high)) : starts.front().at;
  best.deviance = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min(starts.size(), descents); ++i) {
    auto found = descend(levels, task, bounds, starts[i].at, kAllFree);
    if (found.deviance < best.deviance) best = std::move(found);
  }
  return best;
}

}  // namespace palpate::experiment
