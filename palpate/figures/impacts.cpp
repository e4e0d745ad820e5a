#include "palpate/figures/impacts.h"

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

Json strongest(const std::vector<Impact>& impacts, const std::vector<double>& time,
               const std::vector<double>& asked, const std::vector<double>& given) {
  const Impact& largest =
      *std::max_element(impacts.begin(), impacts.end(),
                        [](const Impact& a, const Impact& b) { return a.peak_given < b.peak_given; });
  std::vector<double> ms, wanted, felt;
  for (std::size_t i = 0; i < time.size(); ++i) {
    const double since = 1000.0 * (time[i] - time[largest.first]);
    if (since < -3.0 || since > 1000.0 * (time[largest.last] - time[largest.first]) + 4.0) continue;
    ms.push_back(since);
    wanted.push_back(asked[i]);
    felt.push_back(given[i]);
  }
  return {{"ms", ms}, {"asked_n", wanted}, {"given_n", felt}};
}

// s, physics clock, as the ticks of the haptic loop; folders of before the column was written: the first tick.
double beginning(const PlayFolder& play, const std::vector<double>& ticks) {
  const CsvTable* frames = play.raw("frames.csv");
  return frames != nullptr && frames->has("state_s") ? column(*frames, "state_s").front() : ticks.front();
}

}  // namespace

Json impacts(const PlayFolder& play) {
  constexpr double kAbove = 1.0;  // N, of the plot above the arm's limit
  const CsvTable* haptics = play.raw("haptics.csv");
  if (haptics == nullptr || !has_columns(*haptics, {"time_s", "asked_n", "given_n"})) return nullptr;
  const auto time = column(*haptics, "time_s"), asked = column(*haptics, "asked_n"),
             given = column(*haptics, "given_n");
  const auto impacts = impacts_in(time, asked, given);
  if (impacts.empty()) return nullptr;
  const double begun_s = beginning(play, time);
  std::vector<double> at, peaks;
  for (const Impact& impact : impacts) {
    at.push_back(time[impact.first] - begun_s);
    peaks.push_back(impact.peak_given);
  }
  Json result{{"strongest", strongest(impacts, time, asked, given)},
              {"peaks", {{"time_s", at}, {"given_n", peaks}}},
              {"limit_n", nullptr}};
  if (const auto limit = play.number("force/limit_n")) {
    result["limit_n"] = *limit;
    result["range_n"] = {0.0, *limit + kAbove};
  }
  return result;
}

}  // namespace palpate::figures
