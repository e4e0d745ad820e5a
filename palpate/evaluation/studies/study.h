// What a study of the paper is made of: options in; curves, key figures and what its part of a page draws out.
//
// A study is a pure function of its options: the same seed gives the same numbers on any number of threads.
// Curves are in the units their names state (mm, degrees). Errors: wrong use for options that make no sense.
// Source of the experiments: Bianchi, Knoerlein, Szekely, Harders (2006), "High precision augmented reality
// haptics", sections 4.2 to 4.4.
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/evaluation/studies/repeats.h"
#include "palpate/sim/config/world_file.h"

namespace palpate::evaluation::studies {

struct StudyOptions {
  int runs = 1000;
  std::uint64_t seed = 1;
  sim::config::WorldFile world = sim::config::reference_world();
  RepeatSettings repeats;
};

// What a refused solve leaves; a gap in a plot.
inline constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

// Of the values that are numbers; the others are counted as refused.
struct Summary {
  double mean = 0.0, sd = 0.0, rms = 0.0, median = 0.0, p95 = 0.0;  // not a number where there are no values
  int runs = 0, refused = 0;
};
Summary summary_of(const std::vector<double>& values);

struct CurvePoint {
  double x = 0.0;
  Summary y;
};

struct Curve {
  std::string figure;  // "centre, full sphere": what is drawn together
  std::string label;   // the method
  std::string x_name, y_name;
  std::vector<CurvePoint> points;

  Summary at(double x) const;  // wrong use (exception) where the curve has no point there
};

struct StudyResult {
  std::string name;
  std::vector<Curve> curves;
  Json values;                                             // key figures, for NAME.json
  std::vector<std::pair<std::string, std::string>> files;  // more files, name and content
  std::vector<std::string> lines;                          // key figures, for a person
  Json page = Json::object();                              // what its template needs beyond curves and values
};

Expected<StudyResult> study_marker_noise(const StudyOptions& options);  // Figure 4
Expected<StudyResult> study_tip_noise(const StudyOptions& options);     // Figure 5
Expected<StudyResult> study_points(const StudyOptions& options);        // Figures 7, 8, 9
Expected<StudyResult> study_reset(const StudyOptions& options);         // Figure 10
Expected<StudyResult> study_clouds(const StudyOptions& options);        // Figures 11, 12

struct StudyName {
  const char* name;
  const char* what;
  Expected<StudyResult> (*run)(const StudyOptions&);
  double expected_s;  // of 1000 runs on two cores: its share of the progress bar
};
// In the order of the paper's figures.
const std::vector<StudyName>& studies();

// "centre, full sphere".
inline std::string figure_of(std::string_view what, std::string_view setting) {
  return fmt::format("{}, {}", what, setting);
}
inline double mean_at(const Curve& curve, double x) { return curve.at(x).mean; }
inline Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
const Curve& curve_named(const std::vector<Curve>& curves, std::string_view figure, std::string_view label);

std::string curves_csv(const std::vector<Curve>& curves);
Json curves_json(const std::vector<Curve>& curves);

// Makes the folder; wrong use where nothing can be written there.
Expected<void> can_be_written(const std::filesystem::path& out);
// NAME.json (with `about` beside its values and curves), NAME.csv and the study's own files into the folder.
Expected<void> write_study(const StudyResult& result, const Json& about, const std::filesystem::path& out);

// report.json and report.html of `kind`, the template that draws them: `about` beside "studies", an object of each
// study's values, curves (by figure and label), page and judged (share/report/study-limits.toml).
Expected<void> write_study_report(std::string_view kind, Json about, const std::vector<StudyResult>& results,
                                  const std::filesystem::path& out);

// Runs NAME, or all; with a folder writes report.html, report.json, and NAME.json, NAME.csv for each. `begin` hears of each
// study's number before it runs. Errors: wrong use for an unknown name, for fewer than 1 or more than a
// million runs, for a folder that cannot be written - before anything is computed.
Expected<std::vector<StudyResult>> run_studies(std::string_view name, const StudyOptions& options,
                                               const std::filesystem::path& out,
                                               const std::function<void(std::size_t)>& begin = {});

}  // namespace palpate::evaluation::studies
