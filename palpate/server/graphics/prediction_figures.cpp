#include "palpate/server/graphics/prediction_figures.h"

#include <algorithm>
#include <cctype>
#include <optional>

#include "palpate/core/units.h"
#include "palpate/math/csv_cells.h"

namespace palpate::server::graphics {
namespace {

constexpr double kMm = kMillimetresPerMetre;

// "Ball" as a column's or figure's name: ball.
std::string column_name(std::string name) {
  for (char& c : name)
    c = std::isalnum(static_cast<unsigned char>(c)) != 0
            ? static_cast<char>(std::tolower(static_cast<unsigned char>(c)))
            : '_';
  return name;
}

void put_places(Cells& row, const std::optional<PlaceErrors>& errors) {
  if (!errors) {
    row.insert(row.end(), 3, "");
    return;
  }
  for (const double m : {errors->shown, errors->newest, errors->registered}) put(row, kMm * m);
}

Json json_of(const ErrorSummary& errors) {
  return {{"rms_mm", kMm * errors.rms()},
          {"median_mm", kMm * errors.quantile(0.5)},
          {"p95_mm", kMm * errors.quantile(0.95)}};
}

}  // namespace

Expected<PredictionLog> PredictionLog::begin(const std::filesystem::path& folder,
                                             const scene::SceneDescription& scene) {
  std::vector<std::string> columns{"frame", "ahead_ms", "moment_ms"};
  const auto add_places = [&](const std::string& name) {
    for (const char* of : {"_mm", "_newest_mm", "_registered_mm"}) columns.push_back(name + of);
  };
  add_places("tip");
  std::vector<std::size_t> bodies;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (!scene.bodies[i].name.empty()) {
      add_places(column_name(scene.bodies[i].name));
      bodies.push_back(i);
    }
  for (const char* name : {"head_mm", "head_deg", "shape_mm"}) columns.emplace_back(name);
  auto rows = CsvFile::begin(folder / "realtime_predictions.csv", columns);
  if (!rows) return tl::unexpected(rows.error());
  return PredictionLog(std::move(*rows), std::move(bodies));
}

void PredictionLog::add(const PredictionError& error) {
  Cells row{fmt::format("{}", error.frame)};
  put(row, 1e3 * error.ahead_s);
  put(row, 1e3 * error.moment_s);
  put_places(row, error.tip);
  for (const std::size_t i : bodies_)
    put_places(row, i < error.bodies.size() ? error.bodies[i] : std::nullopt);
  const auto scaled = [](const std::optional<double>& value, double by) {
    return value ? std::optional(by * *value) : std::nullopt;
  };
  put(row, scaled(error.head_m, kMm));
  put(row, scaled(error.head_rad, degrees_from_radians(1.0)));
  put(row, scaled(error.shape_m, kMm));
  rows_.row(row);
}

void PredictionFigures::Places::add(const PlaceErrors& errors) {
  shown.add(errors.shown);
  newest.add(errors.newest);
  registered.add(errors.registered);
}

Json PredictionFigures::Places::json() const {
  return {{"shown", json_of(shown)}, {"newest", json_of(newest)}, {"registered", json_of(registered)}};
}

void PredictionFigures::add(const PredictionError& error) {
  if (++pictures_ > kKept) return;
  ahead_.add(error.ahead_s);
  moment_.add(error.moment_s);
  moment_size_.add(std::abs(error.moment_s));
  if (error.tip) tip_.add(*error.tip);
  if (error.shape_m) shape_.add(*error.shape_m);
  if (error.head_m) head_m_.add(*error.head_m);
  if (error.head_rad) head_rad_.add(*error.head_rad);
  for (std::size_t i = 0; i < std::min(error.bodies.size(), bodies_.size()); ++i)
    if (error.bodies[i]) bodies_[i].add(*error.bodies[i]);
}

Json PredictionFigures::json(const scene::SceneDescription& scene) const {
  Json result{
      {"pictures", pictures_},
      {"ahead_ms_median", 1e3 * ahead_.quantile(0.5)},
      {"moment_ms", {{"median", 1e3 * moment_.quantile(0.5)}, {"p95", 1e3 * moment_size_.quantile(0.95)}}},
      {"tip", tip_.json()}};
  for (std::size_t i = 0; i < std::min(scene.bodies.size(), bodies_.size()); ++i)
    if (!scene.bodies[i].name.empty() && !bodies_[i].shown.empty())
      result["bodies"][column_name(scene.bodies[i].name)] = bodies_[i].json();
  if (!head_rad_.empty())
    result["head"] = {{"rms_mm", kMm * head_m_.rms()}, {"rms_deg", degrees_from_radians(head_rad_.rms())}};
  if (!shape_.empty()) result["shape"] = json_of(shape_);
  return result;
}

}  // namespace palpate::server::graphics
