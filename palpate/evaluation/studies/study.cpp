#include "palpate/evaluation/studies/study.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "palpate/core/csv.h"
#include "palpate/core/statistics.h"
#include "palpate/evaluation/report/page.h"
#include "palpate/figures/limits.h"

namespace palpate::evaluation::studies {
namespace {

constexpr int kMostRuns = 1000000;

// Under figure and label; a list of numbers for each of x and what is drawn.
Json curves_by_name(const std::vector<Curve>& curves) {
  Json by_figure = Json::object();
  for (const auto& curve : curves) {
    Json& lists = by_figure[curve.figure][curve.label];
    for (const char* key : {"x", "mean", "sd", "rms", "median"}) lists[key] = Json::array();
    for (const auto& [x, y] : curve.points) {
      lists["x"].push_back(x);
      lists["mean"].push_back(number_or_null(y.mean));
      lists["sd"].push_back(number_or_null(y.sd));
      lists["rms"].push_back(number_or_null(y.rms));
      lists["median"].push_back(number_or_null(y.median));
    }
  }
  return by_figure;
}

}  // namespace

Expected<void> can_be_written(const std::filesystem::path& out) {
  if (auto made = make_folder(out); !made) return made;
  if (::access(out.c_str(), W_OK | X_OK) != 0)
    return wrong_use("study: {} cannot be written to; name another folder with --out", out.string());
  return {};
}

Summary summary_of(const std::vector<double>& values) {
  Summary summary;
  double sum = 0.0, squares = 0.0;
  for (double v : values) {
    if (!std::isfinite(v)) {
      ++summary.refused;
      continue;
    }
    ++summary.runs;
    sum += v;
    squares += v * v;
  }
  const double n = summary.runs, none = std::numeric_limits<double>::quiet_NaN();
  summary.mean = n > 0 ? sum / n : none;
  summary.rms = n > 0 ? std::sqrt(squares / n) : none;
  double scatter = 0.0;
  for (double v : values)
    if (std::isfinite(v)) scatter += (v - summary.mean) * (v - summary.mean);
  summary.sd = n > 1 ? std::sqrt(scatter / (n - 1.0)) : none;
  summary.median = quantile(values, 0.5);
  summary.p95 = quantile(values, 0.95);
  return summary;
}

Summary Curve::at(double x) const {
  for (const auto& point : points)
    if (std::abs(point.x - x) < 1e-9) return point.y;
  throw std::invalid_argument(fmt::format("study: curve {} has no point at {}", label, x));
}

const Curve& curve_named(const std::vector<Curve>& curves, std::string_view figure, std::string_view label) {
  const auto found = std::find_if(curves.begin(), curves.end(), [&](const Curve& curve) {
    return curve.figure == figure && curve.label == label;
  });
  if (found == curves.end())
    throw std::invalid_argument(fmt::format("study: no curve {} in figure {}", label, figure));
  return *found;
}

std::string curves_csv(const std::vector<Curve>& curves) {
  CsvWriter csv(
      {"name", "label", "x_name", "x", "y_name", "mean", "sd", "rms", "median", "p95", "runs", "refused"});
  const auto cell = [](double v) { return std::isfinite(v) ? number_text(v) : std::string(); };
  const auto text = [](std::string value) {
    std::replace(value.begin(), value.end(), ',', ';');
    return value;
  };
  for (const auto& curve : curves)
    for (const auto& [x, y] : curve.points)
      csv.row(std::vector<std::string>{text(curve.figure), text(curve.label), curve.x_name, cell(x),
                                       curve.y_name, cell(y.mean), cell(y.sd), cell(y.rms), cell(y.median),
                                       cell(y.p95), std::to_string(y.runs), std::to_string(y.refused)});
  return csv.content();
}

Json curves_json(const std::vector<Curve>& curves) {
  Json list = Json::array();
  for (const auto& curve : curves) {
    Json points = Json::array();
    for (const auto& [x, y] : curve.points)
      points.push_back({{curve.x_name, x},
                        {"mean", number_or_null(y.mean)},
                        {"sd", number_or_null(y.sd)},
                        {"rms", number_or_null(y.rms)},
                        {"median", number_or_null(y.median)},
                        {"p95", number_or_null(y.p95)},
                        {"runs", y.runs},
                        {"refused", y.refused}});
    list.push_back(
        {{"figure", curve.figure}, {"label", curve.label}, {"y", curve.y_name}, {"points", points}});
  }
  return list;
}

const std::vector<StudyName>& studies() {
  static const std::vector<StudyName> all{
      {"marker-noise", "Figure 4: tracker noise and the tip's place", study_marker_noise, 11.0},
      {"tip-noise", "Figure 5: a held tip that gives way", study_tip_noise, 18.0},
      {"points", "Figures 7, 8, 9: how many points the arm needs", study_points, 20.0},
      {"reset", "Figure 10: encoders zeroed in odd positions", study_reset, 17.0},
      {"clouds", "Figures 11, 12: the two clouds before and after", study_clouds, 0.2}};
  return all;
}

Expected<void> write_study(const StudyResult& result, const Json& about, const std::filesystem::path& out) {
  Json json{{"study", result.name}};
  if (about.is_object()) json.update(about);
  json["values"] = result.values;
  json["curves"] = curves_json(result.curves);
  if (auto done = write_json(out / (result.name + ".json"), json); !done) return done;
  if (!result.curves.empty())
    if (auto done = write_file(out / (result.name + ".csv"), curves_csv(result.curves)); !done) return done;
  for (const auto& [file, content] : result.files)
    if (auto done = write_file(out / file, content); !done) return done;
  return {};
}

Expected<void> write_study_report(std::string_view kind, Json about, const std::vector<StudyResult>& results,
                                  const std::filesystem::path& out) {
  const report::PageTemplates templates;
  Json report{{"format", 1}, {"kind", kind}};
  report.update(about);
  report["studies"] = Json::object();
  for (const auto& result : results) {
    Json study{{"values", result.values}, {"curves", curves_by_name(result.curves)}, {"page", result.page}};
    auto judged = figures::judged(study, templates.text("study-limits.toml"), "study-limits.toml");
    if (!judged) return tl::unexpected(judged.error());
    study["judged"] = std::move(*judged);
    report["studies"][result.name] = std::move(study);
  }
  return report::write_report(report, templates, out);
}

Expected<std::vector<StudyResult>> run_studies(std::string_view name, const StudyOptions& options,
                                               const std::filesystem::path& out,
                                               const std::function<void(std::size_t)>& begin) {
  std::vector<std::size_t> chosen;
  std::string names;
  for (std::size_t i = 0; i < studies().size(); ++i) {
    names += fmt::format("{}, ", studies()[i].name);
    if (name == "all" || name == studies()[i].name) chosen.push_back(i);
  }
  if (chosen.empty()) return wrong_use("study: there is no study {}; known are {}all", name, names);
  if (options.runs < 1 || options.runs > kMostRuns)
    return wrong_use("study: {} runs; 1 to {} are possible, the paper makes 1000", options.runs, kMostRuns);
  if (!out.empty())
    if (const auto can = can_be_written(out); !can) return tl::unexpected(can.error());

  std::vector<StudyResult> results;
  for (std::size_t i : chosen) {
    if (begin) begin(i);
    auto result = studies()[i].run(options);
    if (!result) return tl::unexpected(result.error());
    const Json about{{"runs", options.runs}, {"seed", options.seed}};
    if (!out.empty())
      if (auto done = write_study(*result, about, out); !done) return tl::unexpected(done.error());
    results.push_back(std::move(*result));
  }
  if (!out.empty()) {
    const Json about{{"runs", options.runs}, {"seed", options.seed}};
    if (auto done = write_study_report("studies", about, results, out); !done)
      return tl::unexpected(done.error());
  }
  return results;
}

}  // namespace palpate::evaluation::studies
