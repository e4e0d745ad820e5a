// The page's part on recorded flights.
#include <algorithm>
#include <cmath>

#include "palpate/evaluation/studies/flights_study.h"

namespace palpate::evaluation::studies {
namespace {

using figures::Mark;
using figures::Plot;
using figures::Series;
using figures::Tone;

constexpr std::array kFlightTones{Tone::rival, Tone::ours, Tone::good, Tone::muted};
constexpr std::array kSetTones{Tone::ours, Tone::rival, Tone::third, Tone::fourth, Tone::good, Tone::bad};

std::vector<double> list(const Json& json) { return json.get<std::vector<double>>(); }

Plot error_over_time(const StudyResult& study, const std::string& set, std::size_t modes) {
  Plot plot{.title = set, .x_label = "ms after the fit window", .y_label = "median error, mm", .log_y = true};
  for (std::size_t m = 0; m < modes; ++m) {
    const auto& curve = curve_named(study.curves, set, kFlightModes[m].label);
    Series series{.name = std::string(kFlightModes[m].label), .tone = kFlightTones[m]};
    series.dashed = m == 2;
    for (const auto& point : curve.points) {
      series.x.push_back(point.x);
      series.y.push_back(point.y.median);
    }
    plot.series.push_back(series);
  }
  return plot;
}

std::string cell(const Json& horizons, int at) {
  for (const auto& h : horizons)
    if (h.at("horizon_ms") == at)
      return fmt::format("{:.1f} / {:.1f}", h.at("median_mm").get<double>(), h.at("p90_mm").get<double>());
  return "-";
}

std::size_t flights_at(const Json& horizons) {
  return horizons.empty() ? 0 : horizons.front().at("flights").get<std::size_t>();
}

void add_table_section(report::Report& page, const StudyResult& study) {
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const std::string& set, const FlightMode& mode, const Json& horizons) {
    std::vector<std::string> row{set, std::string(mode.label)};
    for (const int at : kKeyHorizons_ms) row.push_back(cell(horizons, at));
    row.push_back(fmt::format("{}", flights_at(horizons)));
    rows.push_back(row);
  };
  for (const auto& mode : kFlightModes) {
    const auto& values = study.values.at(std::string(mode.name));
    add("all", mode, values.at("horizons"));
  }
  for (const auto& [set, ignored] : study.values.at("full").at("sets").items())
    for (const auto& mode : kFlightModes)
      add(set, mode, study.values.at(std::string(mode.name)).at("sets").at(set).at("horizons"));
  page.paragraph(
      "Error, mm, median / 90th percentile, after so many milliseconds; flights seen at the first.");
  page.table({"set", "mode", "+100 ms", "+300 ms", "+500 ms", "flights"}, rows);
}

void add_examples_section(report::Report& page, const StudyResult& study) {
  std::vector<Plot> plots;
  for (const auto& example : study.values.at("examples")) {
    Plot plot{.title = example.at("flight").get<std::string>(),
              .x_label = "along the shot, m",
              .y_label = "height, m",
              .equal_axes = true};
    for (std::size_t m = 0; m < 3; ++m) {
      const auto& path = example.at(std::string(kFlightModes[m].name));
      plot.series.push_back({.name = std::string(kFlightModes[m].label),
                             .x = list(path.at("x_m")),
                             .y = list(path.at("z_m")),
                             .tone = kFlightTones[m],
                             .dashed = m == 2});
    }
    const auto& seen = example.at("seen");
    plot.series.push_back({.name = "seen",
                           .x = list(seen.at("x_m")),
                           .y = list(seen.at("z_m")),
                           .mark = Mark::points,
                           .tone = Tone::muted});
    plots.push_back(plot);
  }
  page.paragraph(
      "Of each set the flight whose error in full mode at 300 ms is the middle one, from the side, up to the "
      "first blow of a racket.");
  page.plots(plots);
}

void add_bounces_section(report::Report& page, const StudyResult& study) {
  Plot plot{.title = "Restitution of every bounce on the table",
            .x_label = "speed towards the table, m/s",
            .y_label = "restitution"};
  std::vector<std::vector<std::string>> rows;
  std::size_t i = 0;
  for (const auto& [set, bounces] : study.values.at("bounces").items()) {
    const auto count = bounces.at("told").get<std::size_t>();
    std::vector<std::string> row{set, fmt::format("{}", bounces.at("bounces").get<int>()),
                                 fmt::format("{}", bounces.at("blows").get<int>()),
                                 fmt::format("{}", bounces.at("elsewhere").get<int>())};
    if (count > 0) {
      const auto& e = bounces.at("restitution");
      row[1] = fmt::format("{} ({} told)", row[1], count);
      row.push_back(fmt::format("{:.3f}", e.at("median").get<double>()));
      row.push_back(fmt::format("{:.3f} to {:.3f}", e.at("p10").get<double>(), e.at("p90").get<double>()));
      row.push_back(fmt::format("{:.2f}", bounces.at("approach_m_s").at("median").get<double>()));
      row.push_back(fmt::format("{:.2f}", bounces.at("slide_kept_median").get<double>()));
      row.push_back(fmt::format("{:.3f}", bounces.at("table_height_m").get<double>()));
      plot.series.push_back({.name = set,
                             .x = list(bounces.at("each").at("approach_m_s")),
                             .y = list(bounces.at("each").at("restitution")),
                             .mark = Mark::points,
                             .tone = kSetTones[i++ % kSetTones.size()]});
    } else {
      row.insert(row.end(), 5, "-");
    }
    rows.push_back(row);
  }
  page.paragraph(
      "Bounces are found where a velocity jumps, and counted as the table's where a resting surface explains "
      "the jump at the height of the others of the set; the other jumps are blows of a racket. Restitution "
      "is told where at least 0.1 s were seen on either side.");
  page.table({"set", "bounces", "blows", "elsewhere", "restitution", "p10 to p90", "speed, m/s", "slide kept",
              "ball's height, m"},
             rows);
  if (!plot.series.empty()) page.plot(plot);
}

}  // namespace

void add_flights_section(report::Report& page, const StudyResult& study) {
  page.section("Recorded flights beside the simulator", "flights");
  page.paragraph(
      "Place and velocity of the ball are fitted to the first 100 ms of each flight; then it is simulated. "
      "The error is the distance to the place where the ball was seen, at a time counted from the end of "
      "those 100 ms. One ball, one drag, one table for all recordings; only the height of the table is taken "
      "from the recordings' bounces.");
  std::vector<figures::Figure> figures;
  const auto key = [&](const char* mode, int at) -> double {
    for (const auto& h : study.values.at(mode).at("horizons"))
      if (h.at("horizon_ms") == at) return h.at("median_mm").get<double>();
    return kNoValue;
  };
  for (const int at : kKeyHorizons_ms) {
    const double paper = key("paper", at), full = key("full", at);
    if (!std::isfinite(full)) continue;
    figures.push_back({fmt::format("Median error after {} ms, paper \u2192 full", at),
                       fmt::format("{:.1f} \u2192 {:.1f} mm", paper, full),
                       fmt::format("{:.1f} times less", paper / full), figures::Verdict::none});
  }
  page.figures(figures);
  page.plot(error_over_time(study, "all sets", kFlightModes.size()));
  add_table_section(page, study);
  std::vector<Plot> plots;
  for (const auto& [set, ignored] : study.values.at("full").at("sets").items())
    plots.push_back(error_over_time(study, set, 3));
  page.plots(plots);
  page.aside(
      "\"Spin from the whole flight\" is told what nobody knows after 100 ms of a ball's centre: it bounds "
      "what knowing the spin would be worth. Errors are drawn where recordings reach that far; fewer flights "
      "do so towards the right.");
  add_examples_section(page, study);
  add_bounces_section(page, study);
}

}  // namespace palpate::evaluation::studies
