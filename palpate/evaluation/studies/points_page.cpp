// What the page on Figures 7, 8 and 9 draws and lists beyond curves and values.
#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/evaluation/report/page_templates.h"
#include "palpate/evaluation/studies/internal/points_study.h"
#include "palpate/figures/limits.h"

namespace palpate::evaluation::studies {
namespace {

double number(const Json& value) { return value.is_null() ? kNoValue : value.get<double>(); }

Json by_points(const StudyResult& study) {
  Json rows = Json::array();
  for (const int points : kPointCounts) {
    Json cells = Json::array();
    for (const auto method : {kUncorrected, kOnePass, kAlternating, kEq7, kJoint}) {
      const auto y = curve_named(study.curves, "error to truth", method).at(points);
      cells.push_back({{"mean_mm", number_or_null(y.mean)}, {"runs", y.runs}, {"refused", y.refused}});
    }
    rows.push_back({{"points", points}, {"cells", cells}});
  }
  return rows;
}

// Each row with what `judgement` says of it.
Expected<Json> each_judged(Json rows, std::string_view limits, const std::string& judgement) {
  for (auto& row : rows) {
    const auto all = figures::judged(row, limits, "study-limits.toml");
    if (!all) return all;
    row["judged"] = all->value(judgement, Json::object());
  }
  return rows;
}

// short: fewer regions than were asked for hold the truth; wide: more.
Expected<Json> coverage_rows(const Json& coverage, std::string_view limits) {
  Json rows = Json::array();
  for (const auto& [world, of_world] : coverage.items()) {
    for (Json row : of_world) {
      const double places = number(row.at("unseen_places")), tip = number(row.at("tip_in_marker"));
      row["least"] = number_or_null(std::min(places, tip));
      row["most"] = number_or_null(std::max(places, tip));
      const auto judged = figures::judged(row, limits, "study-limits.toml");
      if (!judged) return judged;
      row["world"] = world;
      for (const auto& [end, bad] : {std::pair{"least", "short"}, std::pair{"most", "wide"}}) {
        const Json one = judged->value(fmt::format("coverage_{}_{}", world, end), Json::object());
        row[std::string("at_") + end] = one.value("limit", Json());
        row[bad] = one.value("verdict", Json()) == "falls short";
      }
      if (row["short"] == true) row["wide"] = false;
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

// The lowest share that a plot of them has to show.
double lowest_share(const StudyResult& study) {
  constexpr double kUsual = 0.8;
  for (const char* world : {"white", "reference"})
    for (const char* what : {"tip at unseen places", "tip in the marker"})
      for (const auto& point :
           curve_named(study.curves, figure_of("stated 95 % regions", world), what).points)
        if (point.y.mean < kUsual) return 0.0;
  return kUsual;
}

}  // namespace

Expected<Json> points_page(const StudyResult& study) {
  const std::string limits(report::PageTemplates().text("study-limits.toml"));
  const auto& held_out = study.values.at("at_70_points").at("held-out error");
  const auto& to_truth = study.values.at("at_70_points").at("error to truth");
  double paper_best = std::numeric_limits<double>::infinity();
  for (const auto method : {kOnePass, kAlternating, kEq7})
    if (const double value = number(to_truth.at(std::string(method))); value < paper_best) paper_best = value;
  const auto bound = each_judged(study.values.at("cramer_rao"), limits, "bound");
  if (!bound) return bound;
  const auto outliers = each_judged(study.values.at("outliers"), limits, "outliers");
  if (!outliers) return outliers;
  const auto coverage = coverage_rows(study.values.at("coverage"), limits);
  if (!coverage) return coverage;
  // A list's items under names, as a template can name them.
  Json truths;
  for (const char* what : {"true_gains", "true_offsets_deg"})
    for (std::size_t j = 0; j < 3; ++j)
      truths[what][fmt::format("j{}", j + 1)] = study.values.at("one_arm").at(what).at(j);
  int runs = 1;
  for (const auto& row : *coverage) runs = std::max(runs, row.at("runs").get<int>());
  return Json{{"by_points", by_points(study)},
              {"paper_best_mm", number_or_null(paper_best)},
              {"floor_excess", number_or_null(number(held_out.at(std::string(kJoint))) /
                                                  number(held_out.at(std::string(kNoiseFloor))) -
                                              1.0)},
              {"cramer_rao", *bound},
              {"coverage", *coverage},
              {"coverage_range", {lowest_share(study), 1.0}},
              {"coverage_runs", runs},
              {"coverage_sd_points", 100.0 * std::sqrt(0.95 * 0.05 / runs)},
              {"true_gains", truths["true_gains"]},
              {"true_offsets_deg", truths["true_offsets_deg"]},
              {"outliers", *outliers}};
}

}  // namespace palpate::evaluation::studies
