#include "palpate/figures/force_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace palpate::figures {
namespace {

struct Impact {
  std::size_t first = 0, last = 0;  // rows
  double peak_asked = 0.0, peak_given = 0.0;
};

// Contiguous runs of force, kept apart where 5 ms or more pass without any.
std::vector<Impact> impacts_in(const std::vector<double>& time, const std::vector<double>& asked,
                               const std::vector<double>& given) {
  std::vector<Impact> impacts;
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (!(std::abs(asked[i]) > 1e-3)) continue;
    if (impacts.empty() || time[i] - time[impacts.back().last] > 0.005) impacts.push_back({i, i, 0.0, 0.0});
    Impact& impact = impacts.back();
    impact.last = i;
    impact.peak_asked = std::max(impact.peak_asked, std::abs(asked[i]));
    impact.peak_given = std::max(impact.peak_given, std::abs(given[i]));
  }
  return impacts;
}

Plot strongest(const std::vector<Impact>& impacts, const std::vector<double>& time,
               const std::vector<double>& asked, const std::vector<double>& given) {
  const Impact& largest =
      *std::max_element(impacts.begin(), impacts.end(),
                        [](const Impact& a, const Impact& b) { return a.peak_given < b.peak_given; });
  Plot plot{.title = "The strongest blow, millisecond by millisecond",
            .x_label = "ms since the contact began",
            .y_label = "N"};
  Series wanted{.name = "asked for", .mark = Mark::steps, .tone = Tone::rival, .dashed = true};
  Series felt{.name = "given", .mark = Mark::steps, .tone = Tone::ours};
  for (std::size_t i = 0; i < time.size(); ++i) {
    const double ms = 1000.0 * (time[i] - time[largest.first]);
    if (ms < -3.0 || ms > 1000.0 * (time[largest.last] - time[largest.first]) + 4.0) continue;
    wanted.x.push_back(ms);
    wanted.y.push_back(asked[i]);
    felt.x.push_back(ms);
    felt.y.push_back(given[i]);
  }
  plot.series = {felt, wanted};
  return plot;
}

Plot peaks(const std::vector<Impact>& impacts, const std::vector<double>& time, double begun_s,
           std::optional<double> limit) {
  constexpr double kAbove = 1.0;  // N, of the plot above the arm's limit
  Plot plot{.title = "Every blow's peak", .x_label = "s since play began", .y_label = "N"};
  Series points{.name = "given", .mark = Mark::points, .tone = Tone::ours};
  for (const Impact& impact : impacts) {
    points.x.push_back(time[impact.first] - begun_s);
    points.y.push_back(impact.peak_given);
  }
  plot.series = {points};
  if (limit) {
    plot.levels.push_back({.at = *limit, .label = "limit of the arm", .tone = Tone::bad});
    plot.y_range = {0.0, *limit + kAbove};
  }
  return plot;
}

}  // namespace

std::string arm_limit(const PlayFolder& play) {
  const auto limit = play.number("force/limit_n");
  return limit ? fmt::format("{:g} N", *limit) : "the most that its motors give";
}

std::optional<Figure> peak_force(const PlayFolder& play, std::string label) {
  const auto peak = play.number("force/peak_n"), limit = play.number("force/limit_n");
  if (!peak) return std::nullopt;
  if (!limit) return Figure{std::move(label), shown(peak, "N"), "", Verdict::none};
  return Figure{std::move(label), shown(peak, "N"),
                fmt::format("at most {}, the arm's limit", arm_limit(play)), at_most(*peak, *limit)};
}

std::optional<Figure> shaped_force(const PlayFolder& play, bool made_up) {
  const auto all = play.number("force/limited_ticks"), at_peak = play.number("force/peak_limited_ticks");
  if (!all) return std::nullopt;
  std::string why;
  if (*all == 0.0) {
    why = "neither the arm's limit nor that of its change was reached";
  } else if (at_peak) {
    const double others = *all - *at_peak;
    why = fmt::format("{} cut at the arm's limit", *at_peak > 0.0 ? fmt::format("{:.0f}", *at_peak) : "none");
    if (others > 0.0)
      why += fmt::format("; {} because a force can change by about 3\u00a0N a millisecond at most{}",
                         *at_peak > 0.0 ? fmt::format("{:.0f}", others) : "all",
                         made_up ? ", made up for right after" : "");
  }
  return Figure{"Milliseconds in which the force was not as asked for", fmt::format("{:.0f}", *all),
                std::move(why), Verdict::none};
}

std::vector<Plot> impact_plots(const PlayFolder& play, double begun_s) {
  const CsvTable* haptics = play.raw("haptics.csv");
  if (haptics == nullptr || !has_columns(*haptics, {"time_s", "asked_n", "given_n"})) return {};
  const auto time = column(*haptics, "time_s"), asked = column(*haptics, "asked_n"),
             given = column(*haptics, "given_n");
  const auto impacts = impacts_in(time, asked, given);
  if (impacts.empty()) return {};
  return {strongest(impacts, time, asked, given),
          peaks(impacts, time, begun_s, play.number("force/limit_n"))};
}

}  // namespace palpate::figures
