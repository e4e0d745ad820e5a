#include "palpate/experiment/psychometric_fit.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "palpate/experiment/internal/data_verdict.h"
#include "palpate/experiment/internal/likelihood_search.h"
#include "palpate/math/chi_square.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::experiment {
namespace {

void check(std::span<const Level> levels, const TaskShape& task) {
  for (const auto& level : levels)
    if (!(level.stimulus > 0.0) || !std::isfinite(level.stimulus) || level.trials < 0 ||
        level.positives < 0 || level.positives > level.trials)
      throw std::invalid_argument(
          "psychometric fit: a stimulus above 0 and at most as many positives as trials are expected");
  const double guess = task.rule == GuessRule::fixed ? task.guess : task.most_lapse;
  if (!(guess >= 0.0) || !(task.most_lapse >= 0.0) || !(guess + task.most_lapse < 0.95))
    throw std::invalid_argument("psychometric fit: guess and lapse rates leave no room for a curve");
}

std::vector<Level> with_trials(std::span<const Level> levels) {
  std::vector<Level> kept(levels.begin(), levels.end());
  std::erase_if(kept, [](const Level& level) { return level.trials == 0; });
  std::sort(kept.begin(), kept.end(), [](const Level& a, const Level& b) { return a.stimulus < b.stimulus; });
  return kept;
}

std::string_view remedy_of(DataVerdict verdict) {
  switch (verdict) {
    case DataVerdict::usable:
      return "they tell the curve";
    case DataVerdict::no_trials:
      return "there is no trial; at least two stimuli with both answers are expected";
    case DataVerdict::one_level:
      return "all trials have one stimulus; at least two are expected, better five or more around the "
             "threshold";
    case DataVerdict::all_positive:
      return "every answer is positive; use weaker stimuli as well";
    case DataVerdict::all_negative:
      return "no answer is positive; use stronger stimuli as well";
    case DataVerdict::no_rise:
      return "positive answers do not become more frequent with the stimulus than chance allows; check the "
             "columns, or "
             "add trials";
    case DataVerdict::separated:
      return "the answers turn between two neighbouring stimuli; use stimuli between them as well";
    case DataVerdict::out_of_range:
      return "the threshold lies far outside of the stimuli; use others";
  }
  return "";
}

// The value of parameter `i` where the profile's deviance has grown by `limit`, on one side of the best.
std::pair<double, bool> profile_end(std::span<const Level> levels, const TaskShape& task,
                                    const SearchBounds& bounds, const SearchResult& best, Eigen::Index i,
                                    double limit, double step) {
  std::array<bool, 3> free = kAllFree;
  free[static_cast<std::size_t>(i)] = false;
  SearchResult last = best;
  const auto excess = [&](double value) {
    Parameters start = last.at;
    start[i] = value;
    auto found = descend(levels, task, bounds, start, free);
    if (!(found.deviance - best.deviance <
          10.0 * limit)) {  // carried away from afar: from the best once more
      start = best.at;
      start[i] = value;
      if (auto again = descend(levels, task, bounds, start, free); again.deviance < found.deviance)
        found = again;
    }
    last = found;
    return found.deviance - best.deviance - limit;
  };
  const double bound = step > 0.0 ? bounds.high[i] : bounds.low[i];
  const auto within = [&](double value) {
    return step > 0.0 ? std::min(value, bound) : std::max(value, bound);
  };
  double inside = best.at[i], outside = within(inside + step);
  while (excess(outside) < 0.0) {
    if (outside == bound) return {bound, true};
    inside = outside;
    step *= 1.5;
    outside = within(outside + step);
  }
  for (int n = 0; n < 40 && std::abs(outside - inside) > 1e-5; ++n) {
    const double middle = 0.5 * (inside + outside);
    (excess(middle) < 0.0 ? inside : outside) = middle;
  }
  return {0.5 * (inside + outside), false};
}

Interval profile(std::span<const Level> levels, const TaskShape& task, const SearchBounds& bounds,
                 const SearchResult& best, Eigen::Index i, double level, double sd) {
  const double limit = chi_square_quantile(1.0 - level, 1.0, true);
  const double widest = 0.5 * (bounds.high[i] - bounds.low[i]), wanted = std::sqrt(limit) * sd;
  // Where the information says nothing, or no number, the search begins as wide as it can.
  const double step = wanted < widest ? std::max(wanted, std::min(1e-4, widest)) : widest;
  const auto low = profile_end(levels, task, bounds, best, i, limit, -step);
  const auto high = profile_end(levels, task, bounds, best, i, limit, step);
  return {std::exp(low.first), std::exp(high.first), low.second, high.second};
}

}  // namespace

std::string_view name_of(DataVerdict verdict) {
  constexpr std::array<std::string_view, 8> kNames{"usable",       "no_trials", "one_level", "all_positive",
                                                   "all_negative", "no_rise",   "separated", "out_of_range"};
  return kNames[static_cast<std::size_t>(verdict)];
}

DataVerdict judge(std::span<const Level> levels, const TaskShape& task) {
  check(levels, task);
  const auto kept = with_trials(levels);
  if (const auto verdict = judge_counts(kept); verdict != DataVerdict::usable) return verdict;
  const auto bounds = bounds_of(kept, task);
  return judge_curve(kept, bounds, search(kept, task, bounds));
}

Expected<PsychometricFit> fit_psychometric(std::span<const Level> levels, const TaskShape& task,
                                           double level) {
  check(levels, task);
  const auto kept = with_trials(levels);
  const auto no_fit = [](DataVerdict verdict) {
    return refused("the answers tell no psychometric function ({}): {}", name_of(verdict),
                   remedy_of(verdict));
  };
  if (const auto verdict = judge_counts(kept); verdict != DataVerdict::usable) return no_fit(verdict);
  const auto bounds = bounds_of(kept, task);
  const auto best = search(kept, task, bounds);
  if (const auto verdict = judge_curve(kept, bounds, best); verdict != DataVerdict::usable)
    return no_fit(verdict);
  PsychometricFit fit;
  fit.curve = curve_of(best.at);
  const Eigen::MatrixXd covariance = covariance_from_information(information_at(kept, task, best.at));
  fit.log_threshold_sd = std::sqrt(covariance(0, 0));
  fit.log_spread_sd = std::sqrt(covariance(1, 1));
  fit.threshold = profile(kept, task, bounds, best, 0, level, fit.log_threshold_sd);
  fit.spread = profile(kept, task, bounds, best, 1, level, fit.log_spread_sd);
  fit.deviance = best.deviance;
  fit.levels = static_cast<int>(kept.size());
  for (const auto& one : kept) fit.trials += one.trials;
  fit.lapse_at_bound = best.at[2] <= 0.0 || best.at[2] >= task.most_lapse;
  return fit;
}

PsychometricCurve most_likely_curve(std::span<const Level> levels, const TaskShape& task) {
  check(levels, task);
  const auto kept = with_trials(levels);
  if (kept.empty() || judge_counts(kept) == DataVerdict::one_level)
    throw std::invalid_argument("psychometric fit: two levels with trials are expected");
  return curve_of(search(kept, task, bounds_of(kept, task)).at);
}

}  // namespace palpate::experiment
