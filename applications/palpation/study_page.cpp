#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "applications/palpation/study_parts.h"
#include "palpate/core/units.h"
#include "palpate/experiment/fit_figures.h"

namespace palpate::applications::palpation {
namespace {

constexpr std::size_t kStudyPlotsOfARow = 2;

std::string title_of(const std::string& name) {
  if (name == "depth") return "Depth of the nodule";
  if (name == "size") return "Size of the nodule";
  if (name == "ratio") return "Stiffness of the nodule";
  if (name == "late") return "Force or picture late: what can be told";
  if (name == "matter") return "Linear instead of neo-Hookean matter";
  if (name == "sessions") return "Practice";
  if (name == "sense-off") return "Sense of force off";
  if (name == "staircase") return "Depth by staircase";
  return "Force or picture late: what it feels like";
}

std::string words_about(const Finding& finding) {
  if (finding.name == "felt-late")
    return "One block is felt or seen late, the other is not. Where the curve crosses a half both feel "
           "alike: "
           "above 1 the late one feels softer than it is, below 1 stiffer.";
  if (finding.name == "sense-off") return "Every place feels alike but for the noise: no curve is expected.";
  const std::string unit =
      finding.varied == Varied::closeness
          ? " The table has it as one over the depth of the nodule's top, 1/mm; the plots have mm."
          : "";
  return "Which of two places has a nodule under it. The threshold is where three of four answers are right, "
         "but for lapses." +
         unit;
}

// Depth in place of its inverse at the axis.
figures::Plot over_depth(figures::Plot plot) {
  const auto invert = [](std::vector<double>& xs) {
    for (double& x : xs) x = 1.0 / x;
    std::reverse(xs.begin(), xs.end());
  };
  for (auto& series : plot.series) {
    invert(series.x);
    std::reverse(series.y.begin(), series.y.end());
    std::reverse(series.hover.begin(), series.hover.end());
  }
  for (auto& level : plot.levels) {
    level.at = 1.0 / level.at;
    if (level.to) level.to = 1.0 / *level.to;
  }
  plot.x_label = "depth of the nodule's top, mm";
  return plot;
}

figures::Section section_of(const Finding& finding) {
  figures::Section section{.title = title_of(finding.name), .anchor = finding.name, .blocks = {}};
  const auto task = experiment::shape_of(finding.conditions);
  section.blocks.emplace_back(words_about(finding));
  section.blocks.emplace_back(experiment::table_of(finding.fits, task));
  std::vector<figures::Plot> row;
  for (const auto& fit : finding.fits) {
    auto plot = experiment::plot_of(fit, task, finding.conditions.stimulus);
    if (finding.varied == Varied::closeness) plot = over_depth(std::move(plot));
    if (finding.varied == Varied::diameter) plot.x_label = "diameter of the nodule, mm";
    if (finding.varied == Varied::ratio) plot.x_label = "stiffness of the nodule over the block's, less 1";
    row.push_back(std::move(plot));
    if (row.size() < kStudyPlotsOfARow && &fit != &finding.fits.back()) continue;
    section.blocks.emplace_back(std::exchange(row, {}));
  }
  return section;
}

figures::Section section_of_searches(const std::vector<SearchRow>& rows) {
  figures::Section section{.title = "Searches of a grid", .anchor = "searches", .blocks = {}};
  section.blocks.emplace_back(
      "Per cent of searches that ended within 10 mm of the nodule: by the grid, in brackets the table's "
      "figure, then a "
      "freer search with as many presses. One column for each Weber fraction.");
  figures::Table table{{"nodule", "contrast"}, {}};
  for (const double weber : kSearchWebers) table.header.push_back(fmt::format("{:.2f}", weber));
  for (const auto& row : rows) {
    std::vector<std::string> cells{
        fmt::format("{:.0f} mm, {:.0f} mm deep", mm_from_metres(row.nodule.diameter),
                    mm_from_metres(row.nodule.top)),
        fmt::format("{:.2f}", row.contrast)};
    for (std::size_t k = 0; k < row.grid.size(); ++k)
      cells.push_back(fmt::format("{:.0f} ({:.0f}); {:.0f}", row.grid[k], row.reference[k], row.freer[k]));
    table.rows.push_back(std::move(cells));
  }
  section.blocks.emplace_back(std::move(table));
  return section;
}

figures::Section section_of_bars(const std::vector<StudyBar>& bars) {
  figures::Section section{.title = "What must come out", .anchor = "bars", .blocks = {}};
  figures::Table table{{"what", "measured", "expected", "met"}, {}};
  for (const auto& bar : bars)
    table.rows.push_back({bar.what, fmt::format("{:.3g}", bar.value), bar.expected, bar.met ? "yes" : "no"});
  section.blocks.emplace_back(std::move(table));
  return section;
}

Json json_of_finding(const Finding& finding) {
  const auto task = experiment::shape_of(finding.conditions);
  Json json{{"name", finding.name},
            {"stimulus", finding.conditions.stimulus},
            {"method",
             finding.conditions.method == experiment::Method::staircase ? "staircase" : "constant-stimuli"},
            {"groups", Json::array()}};
  for (const auto& fit : finding.fits) {
    Json group = experiment::json_of(fit, task);
    if (fit.fit && finding.varied == Varied::closeness) {
      const auto& ends = fit.fit->threshold;
      group["threshold_depth_mm"] = 1.0 / fit.fit->curve.threshold;
      group["threshold_depth_mm_interval"] = {ends.high_open ? Json(nullptr) : Json(1.0 / ends.high),
                                              ends.low_open ? Json(nullptr) : Json(1.0 / ends.low)};
    }
    json["groups"].push_back(std::move(group));
  }
  json["staircases"] = finding.staircases;
  return json;
}

Json json_of_searches(const StudyFindings& all) {
  Json rows = Json::array();
  for (const auto& row : all.searches)
    rows.push_back({{"diameter_mm", mm_from_metres(row.nodule.diameter)},
                    {"depth_mm", mm_from_metres(row.nodule.top)},
                    {"ratio", row.nodule.ratio},
                    {"contrast", row.contrast},
                    {"reference_percent", row.reference},
                    {"grid_percent", row.grid},
                    {"freer_percent", row.freer}});
  return {{"searches", all.plan.searches},
          {"weber_fractions", kSearchWebers},
          {"rows", rows},
          {"sense_off_percent", all.numb_search}};
}

// A line for each stimulus of each cell, which `palpate study psychometric --by experiment,cell` reads.
std::string table_of_answers(const std::vector<Finding>& findings) {
  std::string csv = "experiment,cell,stimulus,positives,trials\n";
  for (const auto& finding : findings)
    for (const auto& fit : finding.fits) {
      std::string cell = experiment::label_of(fit.group);
      std::replace(cell.begin(), cell.end(), ',', ';');
      for (const auto& level : fit.group.levels)
        csv += fmt::format("{},{},{:.12g},{},{}\n", finding.name, cell, level.stimulus, level.positives,
                           level.trials);
    }
  return csv;
}

}  // namespace

scene::StudyOutcome outcome_of(const StudyFindings& all) {
  scene::StudyOutcome outcome;
  const SenseNoise noise = sense_noise(all.plan.trainee.weber_fraction);
  outcome.values = {{"weber_fraction", all.plan.trainee.weber_fraction},
                    {"trials", all.plan.trials},
                    {"seed", all.plan.seed},
                    {"late_ms", 1e3 * all.plan.trainee.late_s},
                    {"noise",
                     {{"force", noise.force},
                      {"memory", noise.memory},
                      {"hand", noise.hand},
                      {"eye", noise.eye},
                      {"eye_weight", TraineeSenses::eye_weight(noise)}}},
                    {"bars", Json::array()},
                    {"experiments", Json::array()},
                    {"searches", json_of_searches(all)}};
  outcome.sections.push_back(section_of_bars(all.bars));
  for (const auto& bar : all.bars) {
    outcome.values["bars"].push_back(
        {{"what", bar.what}, {"value", bar.value}, {"expected", bar.expected}, {"met", bar.met}});
    outcome.lines.push_back(
        fmt::format("{}: {:.3g}; {} {}", bar.what, bar.value, bar.expected, bar.met ? "(met)" : "(NOT met)"));
  }
  for (const auto& finding : all.findings) {
    outcome.values["experiments"].push_back(json_of_finding(finding));
    outcome.sections.push_back(section_of(finding));
    for (const auto& fit : finding.fits)
      outcome.lines.push_back(finding.name + ", " +
                              experiment::line_of(fit, experiment::shape_of(finding.conditions)));
  }
  outcome.sections.push_back(section_of_searches(all.searches));
  outcome.files = {{"palpation_answers.csv", table_of_answers(all.findings)}};
  return outcome;
}

}  // namespace palpate::applications::palpation
