// Of the demo's page: what the run against the wall clock has to draw.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>

#include "palpate/core/statistics.h"
#include "palpate/figures/plot.h"
#include "tools/demo/report_data.h"

namespace palpate::tools::demo {
namespace {

using figures::PlayFolder, figures::column, figures::has_columns;

constexpr double kGround = 0.5;  // below the smallest count, as a logarithmic axis has no zero

// Counts per half octave as an outline that a logarithmic plot can show.
Json outline(const std::vector<std::array<double, 3>>& bins) {
  std::vector<double> x{bins.front()[0]}, y{kGround};
  for (const auto& [from, to, count] : bins) {
    x.insert(x.end(), {from, to});
    y.insert(y.end(), 2, std::max(count, kGround));
  }
  x.push_back(bins.back()[1]);
  y.push_back(kGround);
  return xy(x, y);
}

// How late ticks began: outlines by loop, and the axes that show both.
Json jitter(const CsvTable& table) {
  constexpr std::array<double, 2> kLeast{0.096, 0.128};  // us; whatever is less counts here
  constexpr double kPeriodUs = 1000.0;
  if (!has_columns(table, {"loop", "late_from_us", "late_to_us", "ticks"})) return nullptr;
  const auto from = column(table, "late_from_us"), to = column(table, "late_to_us"),
             ticks = column(table, "ticks");
  double most = 1.0, latest = kPeriodUs;
  Json loops = Json::object();
  for (const char* loop : {"physics", "haptic"}) {
    std::vector<std::array<double, 3>> bins;
    for (std::size_t i = 0; i < table.rows.size(); ++i) {
      if (table.text[i][*table.find("loop")] != loop) continue;
      const bool least = to[i] <= kLeast[1];
      const std::array<double, 3> bin =
          least ? std::array{kLeast[0], kLeast[1], ticks[i]} : std::array{from[i], to[i], ticks[i]};
      if (!bins.empty() && bins.back()[0] == bin[0])
        bins.back()[2] += bin[2];
      else
        bins.push_back(bin);
      most = std::max(most, bins.back()[2]);
      latest = std::max(latest, to[i]);
    }
    if (!bins.empty()) loops[loop] = outline(bins);
  }
  if (loops.empty()) return nullptr;
  return {{"loops", loops}, {"x_range", {kLeast[0], 1.5 * latest}}, {"y_range", {kGround, 2.0 * most}}};
}

// How the two clocks stood to each other, as the graphics server believed. The first exchanges know little; the change
// since then is what can be seen.
Json clock_difference(const CsvTable& sync) {
  if (!has_columns(sync, {"time_s", "offset_s", "offset_error_us", "uncertainty_us"})) return nullptr;
  const auto time = column(sync, "time_s"), offset = column(sync, "offset_s"),
             error = column(sync, "offset_error_us"), sure = column(sync, "uncertainty_us");
  std::size_t first = 0;
  while (first + 1 < time.size() && time[first] < 0.5) ++first;
  std::vector<double> x, estimate, truth, half;
  for (std::size_t i = first; i < time.size(); ++i) {
    x.push_back(time[i]);
    estimate.push_back(1e6 * (offset[i] - offset[first]));
    truth.push_back(estimate.back() - error[i]);
    half.push_back(sure[i]);
  }
  return {{"first_s", offset[first]},
          {"time_s", x},
          {"estimate_us", estimate},
          {"true_us", truth},
          {"band", xy(figures::band_around("", x, estimate, half))}};
}

Json clock_error(const CsvTable& sync) {
  if (!has_columns(sync, {"time_s", "offset_error_us", "uncertainty_us"})) return nullptr;
  const auto time = column(sync, "time_s");
  return {{"time_s", time},
          {"error_us", column(sync, "offset_error_us")},
          {"band", xy(figures::band_around("", time, std::vector<double>(time.size(), 0.0),
                                           column(sync, "uncertainty_us")))}};
}

// How much counts grew in each second from 0 on, under their names; null where none did.
Json per_second(const std::vector<double>& time,
                const std::vector<std::pair<std::string, std::vector<double>>>& so_far) {
  if (time.empty() || time.back() <= 0.0) return nullptr;
  const auto seconds = static_cast<std::size_t>(std::min(std::ceil(time.back()), 3600.0));
  Json growth{{"second", Json::array()}};
  for (std::size_t s = 0; s < seconds; ++s) growth["second"].push_back(fmt::format("{}", s));
  bool any = false;
  for (const auto& [name, counts] : so_far) {
    std::vector<double> grown(seconds, 0.0);
    for (std::size_t i = 0; i < time.size(); ++i) {
      if (time[i] < 0.0) continue;
      const double more = counts[i] - (i > 0 ? counts[i - 1] : 0.0);
      grown[std::min(static_cast<std::size_t>(time[i]), seconds - 1)] += more;
      any = any || more > 0.0;
    }
    growth[name] = grown;
  }
  return any ? growth : Json();
}

Json late_answers(const CsvTable& frames) {
  if (!has_columns(frames, {"time_s", "late", "lost", "repeated", "out_of_order"})) return nullptr;
  auto late = column(frames, "late");
  for (std::size_t i = 1; i < late.size(); ++i) late[i] += late[i - 1];
  return per_second(column(frames, "time_s"), {{"late", late},
                                               {"lost", column(frames, "lost")},
                                               {"repeated", column(frames, "repeated")},
                                               {"out_of_order", column(frames, "out_of_order")}});
}

Json loop_faults(const CsvTable& loops) {
  if (!has_columns(loops,
                   {"time_s", "haptic_overruns", "haptic_missed", "physics_overruns", "physics_missed"}))
    return nullptr;
  std::vector<std::pair<std::string, std::vector<double>>> counts;
  for (const char* name : {"haptic_overruns", "haptic_missed", "physics_overruns", "physics_missed"})
    counts.emplace_back(name, column(loops, name));
  return per_second(column(loops, "time_s"), counts);
}

// The first of them, and of all how many there were of each cause.
Json trips(const CsvTable& table) {
  constexpr std::size_t kShown = 40;
  if (!has_columns(table, {"time_s", "cause", "who", "away_s", "returned", "lost_n_s", "outage_s", "kind"}))
    return nullptr;
  const auto cell = [&](std::size_t row, const char* name) { return table.text[row][*table.find(name)]; };
  const auto number = [&](std::size_t row, const char* name) { return table.rows[row][*table.find(name)]; };
  Json shown = Json::array();
  std::map<std::string, int> causes;
  int long_ones = 0;
  double lost = 0.0;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    ++causes[cell(i, "cause")];
    lost += number(i, "lost_n_s");
    long_ones += cell(i, "kind") == "trip";
    if (i < kShown)
      shown.push_back({{"time_s", number(i, "time_s")},
                       {"cause", cell(i, "cause")},
                       {"who", cell(i, "who")},
                       {"trip", cell(i, "kind") == "trip"},
                       {"outage_ms", 1e3 * number(i, "outage_s")},
                       {"away_ms", 1e3 * number(i, "away_s")},
                       {"returned", number(i, "returned") != 0.0},
                       {"lost_mn_s", 1e3 * number(i, "lost_n_s")}});
  }
  Json counted = Json::array();
  for (const auto& [cause, count] : causes) counted.push_back({{"cause", cause}, {"count", count}});
  Json part{{"count", table.rows.size()}, {"shown", shown}, {"causes", counted}, {"lost_mn_s", 1e3 * lost}};
  part["trips"] = long_ones;
  part["outages"] = table.rows.size() - static_cast<std::size_t>(long_ones);
  if (table.rows.size() > kShown) part["more"] = table.rows.size() - kShown;
  return part;
}

// Of the mean picture and of the slowest of a hundred: what the delay from light to light is made of, ms.
Json latency(const CsvTable& photons) {
  constexpr std::array kParts{"exposure_ms", "transfer_ms", "wait_ms", "draw_ms", "scan_out_ms"};
  if (!photons.has("total_ms")) return nullptr;
  const auto total = column(photons, "total_ms");
  const double slow = quantile(total, 0.99);
  Json parts;
  for (const char* name : kParts) {
    if (!photons.has(name)) return nullptr;
    const auto part = column(photons, name);
    double sum = 0.0, slow_sum = 0.0;
    std::size_t slow_count = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      sum += part[i];
      if (total[i] >= slow) slow_sum += part[i], ++slow_count;
    }
    parts[name] = {sum / static_cast<double>(part.size()), slow_sum / static_cast<double>(slow_count)};
  }
  return parts;
}

// The pictures of the run against the truth, frame by frame; late ones apart.
Json realtime_overlay(const CsvTable& poses) {
  if (!has_columns(poses, {"time_s", "late", "world_px", "tip_px"})) return nullptr;
  constexpr double kSettledS = 1.0;  // clocks settle until then, as the figures have it
  const auto time = column(poses, "time_s"), late = column(poses, "late"), world = column(poses, "world_px"),
             tip = column(poses, "tip_px");
  figures::Series scene, in_time, belated;
  const auto add = [](figures::Series& series, double x, double y) {
    if (!std::isfinite(y)) return;
    series.x.push_back(x);
    series.y.push_back(y);
  };
  for (std::size_t i = 0; i < time.size(); ++i) {
    if (time[i] < kSettledS) continue;
    add(scene, time[i], world[i]);
    add(late[i] != 0.0 ? belated : in_time, time[i], tip[i]);
  }
  if (scene.x.empty()) return nullptr;
  Json part{{"world", xy(scene)}, {"tip", nullptr}, {"tip_late", nullptr}};
  if (!in_time.x.empty()) part["tip"] = xy(in_time);
  if (!belated.x.empty()) part["tip_late"] = xy(belated);
  return part;
}

// How often an exchange took how long, where any did.
Json round_trips(const CsvTable& frames) {
  const auto trips = column(frames, "round_trip_us");
  const double most = trips.empty() ? 0.0 : quantile(trips, 0.99) * 1.25;
  if (!(most > 0.0)) return nullptr;
  return {{"median_us", quantile(trips, 0.5)}, {"counts", xy(figures::histogram("", trips, 0.0, most, 50))}};
}

}  // namespace

Json realtime_data(const PlayFolder& play) {
  Json data = Json::object();
  const auto add = [&](const char* name, const char* file, Json (*part_of)(const CsvTable&)) {
    if (const CsvTable* table = play.raw(file))
      if (Json part = part_of(*table); !part.is_null()) data[name] = std::move(part);
  };
  add("round_trips", "realtime_frames.csv", round_trips);
  add("jitter", "realtime_jitter.csv", jitter);
  add("latency", "realtime_photons.csv", latency);
  add("clock_difference", "realtime_sync.csv", clock_difference);
  add("clock_error", "realtime_sync.csv", clock_error);
  add("realtime_overlay", "realtime_poses.csv", realtime_overlay);
  add("late_answers", "realtime_frames.csv", late_answers);
  add("loop_faults", "realtime_loops.csv", loop_faults);
  add("trips", "realtime_trips.csv", trips);
  const CsvTable *frames = play.raw("realtime_frames.csv"), *loops = play.raw("realtime_loops.csv");
  data["no_late_answers"] = frames != nullptr && frames->has("lost") && !data.contains("late_answers");
  data["no_trips"] = loops != nullptr && !data.contains("trips");
  data["no_loop_faults"] = loops != nullptr && !data.contains("loop_faults");
  return data;
}

}  // namespace palpate::tools::demo
