#include "palpate/experiment/fit_figures.h"

#include <fmt/format.h>

#include <cmath>

#include "palpate/core/text.h"

namespace palpate::experiment {
namespace {

constexpr int kCurvePoints = 120;

std::string with_interval(double value, const Interval& interval) {
  const auto end = [](double x, bool open) { return open ? std::string("?") : fmt::format("{:.3g}", x); };
  return fmt::format("{:.3g} ({} to {})", value, end(interval.low, interval.low_open),
                     end(interval.high, interval.high_open));
}

// What was answered, at each stimulus; a count on hovering.
figures::Series series_of_answers(const GroupFit& one) {
  figures::Series series{.name = "answers", .mark = figures::Mark::points, .tone = figures::Tone::muted};
  for (const auto& level : one.group.levels) {
    if (level.trials == 0) continue;
    series.x.push_back(level.stimulus);
    series.y.push_back(static_cast<double>(level.positives) / level.trials);
    series.hover.push_back(fmt::format("{:.4g}: {} of {}", level.stimulus, level.positives, level.trials));
  }
  return series;
}

figures::Series series_of_fit(const GroupFit& one, const TaskShape& task) {
  figures::Series series{.name = "fit"};
  const double low = std::log(one.group.levels.front().stimulus),
               high = std::log(one.group.levels.back().stimulus);
  for (int i = 0; i <= kCurvePoints; ++i) {
    const double x = std::exp(low + (high - low) * (1.2 * i / kCurvePoints - 0.1));
    series.x.push_back(x);
    series.y.push_back(chance_at(one.fit->curve, task, x).positive);
  }
  return series;
}

}  // namespace

figures::Plot plot_of(const GroupFit& one, const TaskShape& task, const std::string& stimulus) {
  figures::Plot plot;
  plot.title = excerpt(label_of(one.group), 80);
  plot.x_label = excerpt(stimulus, 60);
  plot.y_label = "share of positive answers";
  plot.log_x = true;
  plot.y_range = {-0.02, 1.02};
  plot.series = {series_of_answers(one)};
  if (!one.fit) {
    plot.caption = one.refusal;
    return plot;
  }
  plot.series.push_back(series_of_fit(one, task));
  plot.levels.push_back({.at = one.fit->threshold.low,
                         .label = "threshold, 95 %",
                         .upright = true,
                         .to = one.fit->threshold.high});
  return plot;
}

figures::Table table_of(std::span<const GroupFit> fits, const TaskShape& task) {
  const bool comparison = task.rule == GuessRule::equals_lapse;
  figures::Table table{{"answers", "trials", "threshold", "spread", comparison ? "Weber fraction" : "75 % at",
                        "lapses", "deviance", "share"},
                       {}};
  for (const auto& one : fits) {
    int trials = 0;
    for (const auto& level : one.group.levels) trials += level.trials;
    std::vector<std::string> row{excerpt(label_of(one.group), 80), std::to_string(trials)};
    if (one.fit) {
      const auto& fit = *one.fit;
      const Interval weber{weber_fraction(fit.spread.low), weber_fraction(fit.spread.high),
                           fit.spread.low_open, fit.spread.high_open};
      const double at_75 = stimulus_at(fit.curve, task, 0.75);
      row.insert(row.end(), {with_interval(fit.curve.threshold, fit.threshold),
                             with_interval(fit.curve.spread, fit.spread),
                             comparison ? with_interval(weber_fraction(fit.curve.spread), weber)
                                        : (std::isfinite(at_75) ? fmt::format("{:.3g}", at_75) : "-"),
                             fmt::format("{:.2g}", fit.curve.lapse), fmt::format("{:.3g}", fit.deviance),
                             fmt::format("{:.2f}", one.again->deviance_share)});
    } else {
      row.insert(row.end(), {std::string(name_of(one.verdict)), "-", "-", "-", "-", "-"});
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace palpate::experiment
