#include "palpate/evaluation/studies/psychometric_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/text.h"
#include "palpate/evaluation/report/page.h"
#include "palpate/figures/plot.h"
#include "palpate/figures/section.h"

namespace palpate::evaluation::studies {
namespace {

using experiment::GroupFit;
using experiment::Interval;

constexpr int kCurvePoints = 120;
constexpr std::size_t kPlotsOfARow = 2;

std::string shown(double value, const Interval& interval) {
  const auto end = [](double x, bool open) { return open ? std::string("?") : fmt::format("{:.3g}", x); };
  return fmt::format("{:.3g} ({} to {})", value, end(interval.low, interval.low_open),
                     end(interval.high, interval.high_open));
}

// What was answered, at each stimulus; a count on hovering.
figures::Series answers_of(const GroupFit& one) {
  figures::Series series{.name = "answers", .mark = figures::Mark::points, .tone = figures::Tone::muted};
  for (const auto& level : one.group.levels) {
    if (level.trials == 0) continue;
    series.x.push_back(level.stimulus);
    series.y.push_back(static_cast<double>(level.positives) / level.trials);
    series.hover.push_back(fmt::format("{:.4g}: {} of {}", level.stimulus, level.positives, level.trials));
  }
  return series;
}

figures::Series curve_of(const GroupFit& one, const experiment::TaskShape& task) {
  figures::Series series{.name = "fit"};
  const double low = std::log(one.group.levels.front().stimulus),
               high = std::log(one.group.levels.back().stimulus);
  for (int i = 0; i <= kCurvePoints; ++i) {
    const double x = std::exp(low + (high - low) * (1.2 * i / kCurvePoints - 0.1));
    series.x.push_back(x);
    series.y.push_back(experiment::chance_at(one.fit->curve, task, x).positive);
  }
  return series;
}

figures::Plot plot_of(const GroupFit& one, const PsychometricOptions& options) {
  figures::Plot plot;
  plot.title = excerpt(label_of(one.group), 80);
  plot.x_label = excerpt(options.columns.stimulus, 60);
  plot.y_label = "share of positive answers";
  plot.log_x = true;
  plot.y_range = {-0.02, 1.02};
  plot.series = {answers_of(one)};
  if (!one.fit) {
    plot.caption = one.refusal;
    return plot;
  }
  plot.series.push_back(curve_of(one, options.task));
  plot.levels.push_back({.at = one.fit->threshold.low,
                         .label = "threshold, 95 %",
                         .upright = true,
                         .to = one.fit->threshold.high});
  return plot;
}

figures::Table table_of(const std::vector<GroupFit>& fits, const experiment::TaskShape& task) {
  const bool comparison = task.rule == experiment::GuessRule::equals_lapse;
  figures::Table table{{"answers", "trials", "threshold", "spread", comparison ? "Weber fraction" : "75 % at",
                        "lapses", "deviance", "share"},
                       {}};
  for (const auto& one : fits) {
    int trials = 0;
    for (const auto& level : one.group.levels) trials += level.trials;
    std::vector<std::string> row{excerpt(label_of(one.group), 80), std::to_string(trials)};
    if (one.fit) {
      const auto& fit = *one.fit;
      const Interval weber{experiment::weber_fraction(fit.spread.low),
                           experiment::weber_fraction(fit.spread.high), fit.spread.low_open,
                           fit.spread.high_open};
      const double at_75 = experiment::stimulus_at(fit.curve, task, 0.75);
      row.insert(row.end(), {shown(fit.curve.threshold, fit.threshold), shown(fit.curve.spread, fit.spread),
                             comparison ? shown(experiment::weber_fraction(fit.curve.spread), weber)
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

Json page_of(const std::vector<GroupFit>& fits, const PsychometricOptions& options) {
  figures::Section section{.title = "Psychometric curves", .anchor = "curves", .blocks = {}};
  section.blocks.emplace_back(
      "A cumulative Gaussian of the stimulus' logarithm, with the task's guess rate and a lapse rate, by "
      "maximum likelihood; "
      "in brackets profile intervals of 95 %. A share below 0.05 says that the answers scatter more than "
      "such a curve allows.");
  section.blocks.emplace_back(table_of(fits, options.task));
  for (std::size_t i = 0; i < fits.size(); i += kPlotsOfARow) {
    std::vector<figures::Plot> row;
    for (std::size_t k = i; k < std::min(fits.size(), i + kPlotsOfARow); ++k)
      row.push_back(plot_of(fits[k], options));
    section.blocks.emplace_back(std::move(row));
  }
  return Json{{"sections", report::json_of(std::vector{section})}};
}

}  // namespace

Expected<StudyResult> study_psychometric(const PsychometricOptions& options) {
  const auto table = experiment::read_observations(options.trials, options.columns);
  if (!table) return tl::unexpected(table.error());
  std::vector<GroupFit> fits;
  for (const auto& group : table->groups) {
    fits.push_back(experiment::fit_group(group, options.task, options.bootstrap));
    if (options.repeats.progress)
      options.repeats.progress(static_cast<double>(fits.size()) / static_cast<double>(table->groups.size()));
  }
  StudyResult result;
  result.name = "psychometric";
  const bool comparison = options.task.rule == experiment::GuessRule::equals_lapse;
  result.values = {{"stimulus", options.columns.stimulus},
                   {"task",
                    {{"guess", comparison ? Json("equals lapse") : Json(options.task.guess)},
                     {"most_lapse", options.task.most_lapse}}},
                   {"trials", table->trials},
                   {"practice", table->practice},
                   {"excluded", table->excluded},
                   {"repeats", options.bootstrap.repeats},
                   {"seed", options.bootstrap.seed},
                   {"groups", Json::array()}};
  bool any = false;
  for (const auto& one : fits) {
    result.values["groups"].push_back(experiment::json_of(one, options.task));
    result.lines.push_back(experiment::line_of(one, options.task));
    any = any || one.fit;
  }
  if (!any)
    return refused(
        "{}: {}", table->source,
        fits.size() == 1 ? fits.front().refusal : "no group tells a curve; " + result.lines.front());
  result.page = page_of(fits, options);
  return result;
}

}  // namespace palpate::evaluation::studies
