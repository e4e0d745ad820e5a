// What the page on recorded flights draws and lists beyond curves and values.
#include <algorithm>

#include "palpate/evaluation/studies/flights_study.h"

namespace palpate::evaluation::studies {
namespace {

Json at_horizon(const Json& horizons, int at) {
  for (const auto& h : horizons)
    if (h.at("horizon_ms") == at) return h;
  return nullptr;
}

// Error of one mode over one set of flights, at each of the key horizons.
Json row_of(const std::string& set, const FlightMode& mode, const Json& horizons) {
  Json cells = Json::array();
  for (const int at : kKeyHorizons_ms) {
    const Json h = at_horizon(horizons, at);
    cells.push_back({{"horizon", h}});
  }
  return {{"set", set},
          {"mode", mode.label},
          {"cells", cells},
          {"flights", horizons.empty() ? Json(0) : horizons.front().at("flights")}};
}

const Json& horizons_of(const StudyResult& study, const FlightMode& mode) {
  return study.values.at(std::string(mode.name)).at("horizons");
}

}  // namespace

Json flights_page(const StudyResult& study) {
  Json rows = Json::array(), sets = Json::array(), changes = Json::array(), bounces = Json::array();
  for (const auto& mode : kFlightModes) rows.push_back(row_of("all", mode, horizons_of(study, mode)));
  for (const auto& [set, ignored] : study.values.at("full").at("sets").items()) {
    for (const auto& mode : kFlightModes)
      rows.push_back(
          row_of(set, mode, study.values.at(std::string(mode.name)).at("sets").at(set).at("horizons")));
    Json one{{"set", set}};
    for (const auto& mode : kFlightModes) {
      Json& curve = one[std::string(mode.name)];
      for (const char* key : {"x", "median"}) curve[key] = Json::array();
      for (const auto& point : curve_named(study.curves, set, mode.label).points) {
        curve["x"].push_back(point.x);
        curve["median"].push_back(number_or_null(point.y.median));
      }
    }
    sets.push_back(one);
  }
  for (const int at : kKeyHorizons_ms) {
    const Json paper = at_horizon(horizons_of(study, kFlightModes[0]), at),
               full = at_horizon(horizons_of(study, kFlightModes[1]), at);
    if (paper.is_null() || full.is_null()) continue;
    const double before = paper.at("median_mm").get<double>(), after = full.at("median_mm").get<double>();
    changes.push_back(
        {{"horizon_ms", at}, {"paper_mm", before}, {"full_mm", after}, {"times", before / after}});
  }
  for (const auto& [set, of_set] : study.values.at("bounces").items()) {
    bounces.push_back({{"set", set}, {"any", of_set.at("told").get<std::size_t>() > 0}});
    bounces.back().update(of_set);
  }
  const bool any =
      std::any_of(bounces.begin(), bounces.end(), [](const Json& one) { return one["any"] == true; });
  return {{"changes", changes}, {"rows", rows}, {"sets", sets}, {"bounces", bounces}, {"any_bounces", any}};
}

}  // namespace palpate::evaluation::studies
