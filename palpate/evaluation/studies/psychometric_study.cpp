#include "palpate/evaluation/studies/psychometric_study.h"

#include <fmt/format.h>

#include <algorithm>

#include "palpate/evaluation/report/page.h"
#include "palpate/experiment/fit_figures.h"
#include "palpate/figures/plot.h"
#include "palpate/figures/section.h"

namespace palpate::evaluation::studies {
namespace {

using experiment::GroupFit;

constexpr std::size_t kPlotsOfARow = 2;

Json page_of(const std::vector<GroupFit>& fits, const PsychometricOptions& options) {
  figures::Section section{.title = "Psychometric curves", .anchor = "curves", .blocks = {}};
  section.blocks.emplace_back(
      "A cumulative Gaussian of the stimulus' logarithm, with the task's guess rate and a lapse rate, by "
      "maximum likelihood; "
      "in brackets profile intervals of 95 %. A share below 0.05 says that the answers scatter more than "
      "such a curve allows.");
  section.blocks.emplace_back(experiment::table_of(fits, options.task));
  for (std::size_t i = 0; i < fits.size(); i += kPlotsOfARow) {
    std::vector<figures::Plot> row;
    for (std::size_t k = i; k < std::min(fits.size(), i + kPlotsOfARow); ++k)
      row.push_back(experiment::plot_of(fits[k], options.task, options.columns.stimulus));
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
