// Of the demo's page: what a run on two hosts has to draw and to list, where the cable between them was pulled.
#include <algorithm>
#include <cmath>

#include "palpate/figures/plot.h"
#include "tools/demo/report_data.h"

namespace palpate::tools::demo {
namespace {

using figures::PlayFolder, figures::column, figures::has_columns;

Json events(const PlayFolder& play, double pulled, double out_for) {
  std::vector<std::pair<double, Json>> list{{pulled, {{"pulled", true}}},
                                            {pulled + out_for, {{"plugged", true}, {"after_s", out_for}}}};
  const auto add = [&](const char* key, double from, bool after_plug) {
    if (const auto s = play.number(fmt::format("realtime/network/{}_after_s", key)))
      list.push_back(
          {from + *s, {{key, true}, {"after_s", *s}, {after_plug ? "after_plug" : "after_pull", true}}});
  };
  add("gone", pulled, false);
  add("client_forgotten", pulled, false);
  add("back", pulled + out_for, true);
  add("answers", pulled + out_for, true);
  add("replies", pulled + out_for, true);
  std::sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  Json rows = Json::array();
  for (auto& [at_s, event] : list) {
    event["at_s"] = at_s;
    rows.push_back(std::move(event));
  }
  return rows;
}

// Each picture's round trip; those without one in time stand in a row above all others.
Json timeline(const CsvTable& frames) {
  if (!has_columns(frames, {"time_s", "round_trip_us", "late"})) return nullptr;
  const auto time = column(frames, "time_s"), trip = column(frames, "round_trip_us"),
             late = column(frames, "late");
  double slowest = 0.0;
  for (std::size_t i = 0; i < time.size(); ++i)
    if (late[i] == 0.0 && std::isfinite(trip[i])) slowest = std::max(slowest, trip[i]);
  if (slowest <= 0.0) return nullptr;
  figures::Series answered, without;
  for (std::size_t i = 0; i < time.size(); ++i) {
    figures::Series& series = late[i] == 0.0 ? answered : without;
    series.x.push_back(time[i]);
    series.y.push_back(late[i] == 0.0 ? trip[i] : 2.0 * slowest);
  }
  return {{"answered", xy(answered)}, {"without", xy(without)}};
}

// The y range without the first moments, when little is known yet: they would flatten everything after.
Json clocks(const CsvTable& sync) {
  if (!has_columns(sync, {"time_s", "offset_error_us", "uncertainty_us"})) return nullptr;
  const auto time = column(sync, "time_s"), error = column(sync, "offset_error_us"),
             sure = column(sync, "uncertainty_us");
  double most = 0.0;
  for (std::size_t i = 0; i < time.size(); ++i)
    if (time[i] > 1.0) most = std::max({most, 1.2 * sure[i], 1.2 * std::abs(error[i])});
  return {{"time_s", time},
          {"error_us", error},
          {"band", xy(figures::band_around("", time, std::vector<double>(time.size(), 0.0), sure))},
          {"has_range", most > 0.0},
          {"y_range", {-most, most}}};
}

// Ticks a second, over tenths of a second.
Json loops(const CsvTable& table) {
  if (!has_columns(table, {"time_s", "haptic_ticks", "physics_ticks"})) return nullptr;
  const auto time = column(table, "time_s");
  Json rates;
  for (const char* loop : {"physics", "haptic"}) {
    const auto ticks = column(table, fmt::format("{}_ticks", loop));
    figures::Series rate;
    for (std::size_t i = 0, from = 0; i < time.size(); ++i) {
      if (time[i] - time[from] < 0.1) continue;
      if (time[from] >= 0.0) {
        rate.x.push_back(0.5 * (time[i] + time[from]));
        rate.y.push_back((ticks[i] - ticks[from]) / (time[i] - time[from]));
      }
      from = i;
    }
    rates[loop] = xy(rate);
  }
  return rates;
}

// Before, while and after the cable was out; null where a figure is not known.
Json phases(const PlayFolder& play) {
  Json all;
  for (const char* phase : {"before", "cut", "after"})
    for (const char* key : {"frames", "late", "haptic_ticks", "haptic_overruns", "haptic_missed",
                            "physics_ticks", "physics_overruns", "physics_missed", "clock_error_us_max",
                            "clock_uncertainty_us_max", "clock_inside_share"}) {
      const Json* value = play.find(fmt::format("realtime/network/{}/{}", phase, key));
      all[phase][key] = value == nullptr ? Json() : *value;
    }
  return all;
}

}  // namespace

Json network_data(const PlayFolder& play) {
  const auto pulled = play.number("realtime/network/cut_at_s"),
             out_for = play.number("realtime/network/cut_for_s");
  if (!pulled || !out_for) return Json::object();
  Json data{{"plugged_at_s", *pulled + *out_for},
            {"events", events(play, *pulled, *out_for)},
            {"phases", phases(play)}};
  const auto add = [&](const char* name, const char* file, Json (*part_of)(const CsvTable&)) {
    if (const CsvTable* table = play.raw(file))
      if (Json part = part_of(*table); !part.is_null()) data[name] = std::move(part);
  };
  add("timeline", "realtime_frames.csv", timeline);
  add("clocks", "realtime_sync.csv", clocks);
  add("loops", "realtime_loops.csv", loops);
  return data;
}

}  // namespace palpate::tools::demo
