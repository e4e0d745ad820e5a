// Of the demo's page: what the calibrations of arm, stylus tip and lens have to draw.
#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/figures/plot.h"
#include "tools/demo/report_data.h"

namespace palpate::tools::demo {
namespace {

using figures::PlayFolder, figures::column, figures::has_columns;

constexpr std::array kMethods{"uncorrected", "one-pass", "alternating", "eq7", "joint"};

// Rows of `table` whose text in `key` is `value`, one column of them.
std::vector<double> where(const CsvTable& table, std::string_view key, std::string_view value,
                          std::string_view wanted) {
  std::vector<double> found;
  const auto at = table.find(key), column_at = table.find(wanted);
  if (!at || !column_at) return found;
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    if (table.text[i][*at] == value) found.push_back(table.rows[i][*column_at]);
  return found;
}

// A template's names hold no hyphens.
std::string key_of(std::string method) {
  std::replace(method.begin(), method.end(), '-', '_');
  return method;
}

Json shares(const CsvTable& errors) {
  Json by_method;
  for (const char* method : kMethods)
    if (auto values = where(errors, "method", method, "error_mm"); !values.empty())
      by_method[key_of(method)] = xy(figures::cumulative("", std::move(values)));
  return by_method;
}

// Each stroke: its true place, its end, and a gap.
Json strokes(const CsvTable& errors) {
  constexpr double kMagnified = 10.0;
  constexpr std::size_t kMost = 250;
  if (!has_columns(errors, {"x_mm", "y_mm", "z_mm", "dx_mm", "dy_mm", "dz_mm"})) return nullptr;
  Json by_method;
  for (const char* method : kMethods) {
    std::array<std::vector<double>, 3> place, error;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::string axis(1, "xyz"[k]);
      place[k] = where(errors, "method", method, axis + "_mm");
      error[k] = where(errors, "method", method, "d" + axis + "_mm");
    }
    std::vector<double> points;
    for (std::size_t i = 0; i < std::min(place[0].size(), kMost); ++i) {
      for (std::size_t k = 0; k < 3; ++k) points.push_back(place[k][i]);
      for (std::size_t k = 0; k < 3; ++k) points.push_back(place[k][i] + kMagnified * error[k][i]);
      points.insert(points.end(), 3, NAN);
    }
    by_method[key_of(method)] = points;
  }
  return by_method;
}

// How the predicted error falls with the poses, shown where they help most and chosen by the person; and as many of
// the person's own choice as are as good as thirty shown ones: worth_poses, or none of all `most_poses`.
Json guidance(const CsvTable& table) {
  if (!has_columns(table, {"poses", "guided_mm", "chosen_mm"})) return nullptr;
  const auto poses = column(table, "poses"), guided = column(table, "guided_mm"),
             chosen = column(table, "chosen_mm");
  Json part{{"poses", poses},
            {"guided_mm", guided},
            {"chosen_mm", chosen},
            {"worth_poses", nullptr},
            {"most_poses", nullptr}};
  const auto thirty = std::find(poses.begin(), poses.end(), 30.0);
  if (thirty == poses.end()) return part;
  const double there = guided[static_cast<std::size_t>(thirty - poses.begin())];
  const auto as_good =
      std::find_if(chosen.begin(), chosen.end(), [&](double error) { return error <= there; });
  if (as_good == chosen.end())
    part["most_poses"] = poses.back();
  else
    part["worth_poses"] = poses[static_cast<std::size_t>(as_good - chosen.begin())];
  return part;
}

Json pivot_path(const CsvTable& pivot) {
  constexpr std::size_t kMost = 800;
  if (!has_columns(pivot, {"x_mm", "y_mm", "z_mm"})) return nullptr;
  const auto x = column(pivot, "x_mm"), y = column(pivot, "y_mm"), z = column(pivot, "z_mm");
  std::vector<double> points;
  for (std::size_t i = 0; i < x.size(); i += std::max<std::size_t>(1, x.size() / kMost))
    points.insert(points.end(), {x[i], y[i], z[i]});
  return {{"points_mm", points}};
}

Json lens_rows(const CsvTable& lens) {
  if (!lens.has("which")) return nullptr;
  const auto which = *lens.find("which");
  Json rows = Json::array();
  for (std::size_t c = 0; c < lens.header.size(); ++c) {
    if (c == which) continue;
    const std::string& name = lens.header[c];
    if (name == "lens") continue;  // its kind, a word
    Json row{{"name", name}, {"pixels", name[0] == 'f' || name[0] == 'c'}, {"estimated", ""}, {"true", ""}};
    for (std::size_t i = 0; i < lens.rows.size(); ++i)
      row[lens.text[i][which] == "true" ? "true" : "estimated"] = lens.rows[i][c];
    rows.push_back(row);
  }
  return {{"numbers", rows}};
}

}  // namespace

Json calibration_data(const PlayFolder& play) {
  Json data = Json::object();
  const auto add = [&](const char* name, const char* file, Json (*part_of)(const CsvTable&)) {
    if (const CsvTable* table = play.raw(file))
      if (Json part = part_of(*table); !part.is_null()) data[name] = std::move(part);
  };
  add("arm_shares", "arm_errors.csv", shares);
  add("arm_strokes", "arm_errors.csv", strokes);
  add("guidance", "arm_guidance.csv", guidance);
  add("pivot", "pivot.csv", pivot_path);
  add("lens", "lens.csv", lens_rows);
  return data;
}

}  // namespace palpate::tools::demo
