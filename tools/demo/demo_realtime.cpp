// The demo report's part about the run against the wall clock.
#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/core/statistics.h"
#include "tools/demo/demo_sections.h"

namespace palpate::tools::demo {

namespace {

constexpr double kGround = 0.5;  // below the smallest count, as a logarithmic axis has no zero

// Counts per half octave as an outline that a logarithmic plot can show.
figures::Series outline(std::string name, const std::vector<std::array<double, 3>>& bins, figures::Tone tone,
                        bool filled) {
  figures::Series series{.name = std::move(name), .tone = tone, .in_legend = !filled, .filled = filled};
  const auto add = [&series](double x, double y) {
    series.x.push_back(x);
    series.y.push_back(std::max(y, kGround));
  };
  add(bins.front()[0], kGround);
  for (const auto& [from, to, count] : bins) {
    add(from, count);
    add(to, count);
  }
  add(bins.back()[1], kGround);
  return series;
}

std::optional<figures::Plot> jitter_plot(const figures::PlayFolder& data) {
  const CsvTable* table = data.raw("realtime_jitter.csv");
  if (table == nullptr || !figures::has_columns(*table, {"loop", "late_from_us", "late_to_us", "ticks"}))
    return std::nullopt;
  const auto from = figures::column(*table, "late_from_us"), to = figures::column(*table, "late_to_us"),
             ticks = figures::column(*table, "ticks");
  constexpr std::array<double, 2> kLeast{0.096, 0.128};  // us; whatever is less counts here
  constexpr double kPeriodUs = 1000.0;
  figures::Plot plot{.title = "How late the ticks of the loops begin",
                     .x_label = "\u00b5s after they were due",
                     .y_label = "ticks",
                     .log_x = true,
                     .log_y = true};
  double most = 1.0, latest = kPeriodUs;
  for (const auto& [loop, tone] :
       {std::pair("physics", figures::Tone::rival), std::pair("haptic", figures::Tone::ours)}) {
    std::vector<std::array<double, 3>> bins;
    for (std::size_t i = 0; i < table->rows.size(); ++i) {
      if (table->text[i][*table->find("loop")] != loop) continue;
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
    if (bins.empty()) continue;
    plot.series.push_back(outline(std::string(loop) + " loop", bins, tone, true));
    plot.series.push_back(outline(std::string(loop) + " loop", bins, tone, false));
  }
  if (plot.series.empty()) return std::nullopt;
  plot.x_range = {kLeast[0], 1.5 * latest};
  plot.y_range = {kGround, 2.0 * most};
  plot.levels = {{.at = kPeriodUs, .label = "next tick due", .tone = figures::Tone::bad, .upright = true}};
  plot.caption =
      "Each step is half an octave wide. Both axes are logarithmic: the few late ticks on the right are what "
      "matters. The column at the left end also counts everything quicker.";
  return plot;
}

// How the two clocks stood to each other, as the graphics server believed.
std::optional<figures::Plot> clock_difference_plot(const CsvTable& sync) {
  if (!figures::has_columns(sync, {"time_s", "offset_s", "offset_error_us", "uncertainty_us"}))
    return std::nullopt;
  const auto time = figures::column(sync, "time_s"), offset = figures::column(sync, "offset_s"),
             error = figures::column(sync, "offset_error_us"), sure = figures::column(sync, "uncertainty_us");
  // The first exchanges know little; the change since then is what can be seen.
  std::size_t first = 0;
  while (first + 1 < time.size() && time[first] < 0.5) ++first;
  std::vector<double> x, estimate, truth, half;
  for (std::size_t i = first; i < time.size(); ++i) {
    x.push_back(time[i]);
    estimate.push_back(1e6 * (offset[i] - offset[first]));
    truth.push_back(estimate.back() - error[i]);
    half.push_back(sure[i]);
  }
  figures::Plot plot{.title = "Physics clock minus graphics clock: the change since the start",
                     .x_label = "s",
                     .y_label = "\u00b5s"};
  plot.series = {figures::band_around("stated uncertainty", x, estimate, half),
                 {.name = "truth", .x = x, .y = truth, .tone = figures::Tone::rival, .dashed = true},
                 {.name = "estimate", .x = x, .y = estimate, .tone = figures::Tone::ours}};
  plot.caption = fmt::format(
      "At the start the difference was {:.6f} s. The slope is the clocks' drift against each other: 100 "
      "\u00b5s in a second are 100 parts in a million.",
      offset[first]);
  return plot;
}

// How much counts grew in each second from 0 on; empty where none did.
std::vector<figures::Series> per_second(
    const std::vector<double>& time, const std::vector<std::pair<std::string, std::vector<double>>>& so_far) {
  constexpr std::array<figures::Tone, 4> kTones{figures::Tone::ours, figures::Tone::rival,
                                                figures::Tone::third, figures::Tone::fourth};
  if (time.empty() || time.back() <= 0.0) return {};
  const auto seconds = static_cast<std::size_t>(std::min(std::ceil(time.back()), 3600.0));
  std::vector<figures::Series> list;
  bool any = false;
  for (const auto& [name, counts] : so_far) {
    figures::Series series{
        .name = name, .mark = figures::Mark::bars, .tone = kTones[list.size() % kTones.size()]};
    for (std::size_t s = 0; s < seconds; ++s) series.labels.push_back(fmt::format("{}", s));
    series.y.assign(seconds, 0.0);
    for (std::size_t i = 0; i < time.size(); ++i) {
      if (time[i] < 0.0) continue;
      const auto second = std::min(static_cast<std::size_t>(time[i]), seconds - 1);
      const double grown = counts[i] - (i > 0 ? counts[i - 1] : 0.0);
      series.y[second] += grown;
      any = any || grown > 0.0;
    }
    list.push_back(std::move(series));
  }
  return any ? list : std::vector<figures::Series>{};
}

std::optional<figures::Plot> lateness_plot(const CsvTable& frames) {
  if (!figures::has_columns(frames, {"time_s", "late", "lost", "repeated", "out_of_order"}))
    return std::nullopt;
  auto late = figures::column(frames, "late");
  for (std::size_t i = 1; i < late.size(); ++i) late[i] += late[i - 1];
  figures::Plot plot{
      .title = "Answers that were not as they should be", .x_label = "second of the leg", .y_label = "count"};
  plot.series = per_second(figures::column(frames, "time_s"),
                           {{"late for their picture", late},
                            {"lost", figures::column(frames, "lost")},
                            {"came twice", figures::column(frames, "repeated")},
                            {"out of order", figures::column(frames, "out_of_order")}});
  if (plot.series.empty()) return std::nullopt;
  plot.caption =
      "Late: the picture was drawn with the state before. Lost: no answer within a second, counted when that "
      "is over.";
  return plot;
}

std::optional<figures::Plot> overruns_plot(const CsvTable& loops) {
  if (!figures::has_columns(
          loops, {"time_s", "haptic_overruns", "haptic_missed", "physics_overruns", "physics_missed"}))
    return std::nullopt;
  figures::Plot plot{
      .title = "Ticks of the loops that went wrong", .x_label = "second of the leg", .y_label = "ticks"};
  plot.series = per_second(figures::column(loops, "time_s"),
                           {{"haptic: overrun", figures::column(loops, "haptic_overruns")},
                            {"haptic: left out", figures::column(loops, "haptic_missed")},
                            {"physics: overrun", figures::column(loops, "physics_overruns")},
                            {"physics: left out", figures::column(loops, "physics_missed")}});
  if (plot.series.empty()) return std::nullopt;
  plot.caption =
      "Of a thousand each second. Overrun: still at work, or kept from it by the machine, when the next tick "
      "was due. Left out: skipped because of that, never made up for in a burst.";
  return plot;
}

// Of the mean picture and of the slowest of a hundred: what the delay from light to light is made of.
std::optional<figures::Plot> latency_parts_plot(const CsvTable& photons) {
  constexpr std::array<std::pair<const char*, const char*>, 5> kParts{{{"exposure_ms", "exposure"},
                                                                       {"transfer_ms", "transfer"},
                                                                       {"wait_ms", "wait"},
                                                                       {"draw_ms", "draw"},
                                                                       {"scan_out_ms", "scan-out"}}};
  constexpr std::array<figures::Tone, 5> kTones{figures::Tone::muted, figures::Tone::ours,
                                                figures::Tone::third, figures::Tone::rival,
                                                figures::Tone::fourth};
  if (!figures::has_columns(photons,
                            {"exposure_ms", "transfer_ms", "wait_ms", "draw_ms", "scan_out_ms", "total_ms"}))
    return std::nullopt;
  const auto total = figures::column(photons, "total_ms");
  const double slow = quantile(total, 0.99);
  figures::Plot plot{
      .title = "From light to light", .x_label = "ms", .y_label = "", .stacked = true, .sideways = true};
  for (std::size_t k = 0; k < kParts.size(); ++k) {
    const auto part = figures::column(photons, kParts[k].first);
    double sum = 0.0, slow_sum = 0.0;
    std::size_t slow_count = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      sum += part[i];
      if (total[i] >= slow) slow_sum += part[i], ++slow_count;
    }
    figures::Series series{.name = kParts[k].second, .mark = figures::Mark::bars, .tone = kTones[k]};
    series.labels = {"mean", "slowest 1 %"};
    series.y = {sum / static_cast<double>(part.size()), slow_sum / static_cast<double>(slow_count)};
    plot.series.push_back(std::move(series));
  }
  plot.height_px = 240;
  plot.caption =
      "From the middle of the camera's exposure until the picture made of the image leaves the display. "
      "Exposure: its second half. Transfer: until the image was there. Wait: until it was taken up. "
      "Scan-out: as stated; it and transfer are measured as a sum.";
  return plot;
}

// The pictures of the run against the truth, frame by frame; late ones apart.
std::optional<figures::Plot> realtime_overlay_plot(const CsvTable& poses) {
  if (!figures::has_columns(poses, {"time_s", "late", "world_px", "tip_px"})) return std::nullopt;
  const auto time = figures::column(poses, "time_s"), late = figures::column(poses, "late"),
             world = figures::column(poses, "world_px"), tip = figures::column(poses, "tip_px");
  figures::Series scene{.name = "real scene", .mark = figures::Mark::points, .tone = figures::Tone::ours},
      in_time{.name = "stylus tip", .mark = figures::Mark::points, .tone = figures::Tone::rival},
      belated{.name = "stylus tip, answer late", .mark = figures::Mark::points, .tone = figures::Tone::bad};
  constexpr double kSettledS = 1.0;  // clocks settle until then, as the figures have it
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
  if (scene.x.empty()) return std::nullopt;
  figures::Plot plot{.title = "Overlay error in real time, frame by frame",
                     .x_label = "s",
                     .y_label = "px",
                     .from_zero = true};
  for (auto* series : {&in_time, &belated, &scene})
    if (!series->x.empty()) plot.series.push_back(std::move(*series));
  plot.caption =
      "As above, against what the laboratory knew of each image and told nobody until the leg was over.";
  return plot;
}

// Microseconds, or milliseconds where there are a thousand of them.
std::string shown_us(double us) {
  return us < 1000.0 ? figures::shown(us, "\u00b5s") : figures::shown(us / 1000.0, "ms");
}

constexpr double kSpins_us = 1.0;  // a thread that sleeps is never woken so quickly

// How late the haptic loop's ticks began, and how many never did: one without the other is half of it.
std::optional<figures::Figure> haptic_lateness(const figures::PlayFolder& data) {
  const auto most = data.number("realtime/haptic/jitter_us/max");
  const auto nearly_all = data.number("realtime/haptic/jitter_us/p99");
  if (!most || !nearly_all) return std::nullopt;
  std::string note = *nearly_all < kSpins_us ? "99 % of them by less than 1\u00a0\u00b5s"
                                             : "99 % of them by at most " + shown_us(*nearly_all);
  if (const auto missed = data.number("realtime/haptic/missed")) {
    const auto begun = data.number("realtime/haptic/ticks");
    note += *missed == 0.0 ? "; none left out" : fmt::format("; {:.0f}", *missed);
    if (*missed > 0.0) note += begun ? fmt::format(" of {:.0f} left out", *begun + *missed) : " left out";
    if (const auto row = data.number("realtime/haptic/missed_in_a_row"); row && *row > 1.0)
      note += fmt::format(", up to {:.0f} in a row", *row);
  }
  return figures::Figure{"Haptic ticks began late by", "at most " + shown_us(*most), std::move(note),
                         figures::Verdict::none};
}

// How often an exchange took how long, where any did.
std::optional<figures::Plot> round_trip_plot(const CsvTable& frames) {
  if (!frames.has("round_trip_us")) return std::nullopt;
  const auto trips = figures::column(frames, "round_trip_us");
  const double most = quantile(trips, 0.99) * 1.25;
  if (!(most > 0.0)) return std::nullopt;
  figures::Plot plot{.title = "Round trips", .x_label = "\u00b5s", .y_label = "frames"};
  plot.series = {figures::histogram("round trip", trips, 0.0, most, 50)};
  plot.series.front().in_legend = false;
  plot.levels.push_back(
      {.at = quantile(trips, 0.5), .label = "median", .tone = figures::Tone::rival, .upright = true});
  plot.caption = "The outermost column also counts everything slower.";
  return plot;
}

std::optional<figures::Plot> clock_error_plot(const CsvTable& sync) {
  if (!figures::has_columns(sync, {"time_s", "offset_error_us", "uncertainty_us"})) return std::nullopt;
  const auto time = figures::column(sync, "time_s"), error = figures::column(sync, "offset_error_us"),
             sure = figures::column(sync, "uncertainty_us");
  const figures::Series band =
      figures::band_around("stated uncertainty", time, std::vector<double>(time.size(), 0.0), sure);
  figures::Plot plot{
      .title = "Clock difference, estimate against truth", .x_label = "s", .y_label = "\u00b5s"};
  plot.series = {band, {.name = "error", .x = time, .y = error, .tone = figures::Tone::ours}};
  plot.caption =
      "Estimate minus truth, which only the simulation knows. Where the line lies inside of the band, what "
      "the system said of its own uncertainty was right.";
  return plot;
}

std::vector<figures::Figure> real_time_figures(const figures::PlayFolder& data) {
  std::vector<figures::Figure> figures;
  const auto add = [&](std::string_view path, std::string label, std::string_view unit, std::string note,
                       std::optional<double> bar = std::nullopt) {
    const auto value = data.number(path);
    if (!value) return;
    figures.push_back({std::move(label), figures::shown(value, unit), std::move(note),
                       bar ? figures::at_most(*value, *bar) : figures::Verdict::none});
  };
  add("realtime/exchange/round_trip_us/median", "Round trip, median", "\u00b5s",
      "the 2006 paper: 300 to 800 \u00b5s");
  add("realtime/exchange/round_trip_us/p99", "Round trip, 99 % below", "\u00b5s", "");
  if (const auto late = data.number("realtime/exchange/late"),
      frames = data.number("realtime/exchange/frames");
      late && frames) {
    figures.push_back(
        {"Late answers", fmt::format("{:.0f} of {:.0f}", *late, *frames), "", figures::Verdict::none});
  }
  add("realtime/sync/offset_error_us_p99", "Clocks agree, 99 % within", "\u00b5s", "at most 50 \u00b5s",
      50.0);
  add("realtime/sync/uncertainty_us", "Uncertainty it states itself", "\u00b5s", "");
  if (const auto rate = data.number("realtime/haptic/rate_hz"))
    figures.push_back({"Haptic loop", figures::shown(*rate, "Hz"), "at least 990 Hz of 1000",
                       figures::at_least(*rate, 990.0)});
  if (auto late = haptic_lateness(data)) figures.push_back(std::move(*late));
  if (const auto lost = data.number("realtime/force/lost_impulse_rel"))
    figures.push_back({"Impulse the hand did not get", figures::shown(100.0 * *lost, "%"),
                       "at most 1 %; more where ticks were left out during an impact",
                       figures::at_most(*lost, 0.01)});
  add("realtime/physics/rate_hz", "Physics loop", "Hz", "");
  add("realtime/graphics/rate_hz", "Pictures", "Hz",
      "as fast as this machine draws two pictures, the camera's and ours");
  add("realtime/overlay/world_px_rms", "Real scene, rms", "px",
      fmt::format("{} in lock-step", figures::shown(data.number("registration/world_px_rms"), "px")));
  add("realtime/overlay/tip_px_rms_in_time", "Stylus tip, rms", "px",
      fmt::format("where the answer came in time; {} in lock-step",
                  figures::shown(data.number("registration/tip_px_rms"), "px")));
  add("realtime/overlay/tip_px_rms_late", "... where it was late", "px", "drawn with the state before");
  add("realtime/photon_to_photon/median_ms", "From light to light, median", "ms",
      "from the camera's exposure to the light of its picture");
  add("realtime/photon_to_photon/p99_ms", "From light to light, 99 % below", "ms", "");
  add("realtime/photon_to_photon/instrument_error_ms", "... measured to within, 99 %", "ms", "at most 1 ms",
      1.0);
  return figures;
}

void add_words(evaluation::report::Report& page, const figures::PlayFolder& data) {
  page.paragraph(
      "Everything above ran in lock-step on a virtual clock, so that no figure depends on how quick the "
      "machine is. This part ran in real time: world, physics server and graphics server as three processes, "
      "the last one's clock disguised with an offset and a drift. Its figures belong to the machine it ran "
      "on.");
  if (data.find("realtime/network") != nullptr)
    page.paragraph(
        "In this run a network cable was pulled for a while, which the figures here include; the next part "
        "tells of it.");
}

// A loop that only sleeps wakes tens of microseconds late: it needs no explanation.
void explain_lateness(evaluation::report::Report& page, const figures::PlayFolder& data) {
  if (const auto usual = data.number("realtime/haptic/jitter_us/p50"); usual && *usual < kSpins_us)
    page.aside(
        "The haptic loop watches the clock until a tick is due. A tick therefore begins at the right moment "
        "to well within a microsecond, or it is late because the machine gave the loop's core to something "
        "else: the few late ones are what counts. What falls due in such a pause is left out, for a force "
        "that belongs to a moment gone by helps nobody.");
}

// Those that can be drawn of what the run has left, a row each: how quick it was, the clocks, what was late.
void add_plots(evaluation::report::Report& page, const figures::PlayFolder& data) {
  std::vector<figures::Plot> quickness, clocks, counts;
  const auto add = [&data](std::vector<figures::Plot>& row, const char* file, auto plot_of) {
    if (const CsvTable* table = data.raw(file))
      if (auto plot = plot_of(*table)) row.push_back(std::move(*plot));
  };
  add(quickness, "realtime_frames.csv", round_trip_plot);
  if (auto plot = jitter_plot(data)) quickness.push_back(std::move(*plot));
  add(quickness, "realtime_photons.csv", latency_parts_plot);
  add(clocks, "realtime_sync.csv", clock_difference_plot);
  add(clocks, "realtime_sync.csv", clock_error_plot);
  add(counts, "realtime_poses.csv", realtime_overlay_plot);
  add(counts, "realtime_frames.csv", lateness_plot);
  add(counts, "realtime_loops.csv", overruns_plot);
  for (const auto& plots : {quickness, clocks, counts})
    if (!plots.empty()) page.plots(plots);
}

// What no plot shows, as there is nothing to count.
void say_what_went_well(evaluation::report::Report& page, const figures::PlayFolder& data) {
  const CsvTable* frames = data.raw("realtime_frames.csv");
  const CsvTable* loops = data.raw("realtime_loops.csv");
  if (frames != nullptr && frames->has("lost") && !lateness_plot(*frames))
    page.aside("No answer came late, twice or out of order in this run, and none was lost.");
  if (loops != nullptr && !overruns_plot(*loops))
    page.aside("No tick of either loop was still at work when the next was due, and none was left out.");
}

}  // namespace

void add_real_time_section(evaluation::report::Report& page, const figures::PlayFolder& data) {
  if (data.find("realtime") == nullptr) return;
  const std::vector<figures::Figure> figures = real_time_figures(data);
  if (figures.empty()) return;
  page.section("Against the wall clock", "real-time");
  add_words(page, data);
  page.figures(figures);
  explain_lateness(page, data);
  add_plots(page, data);
  say_what_went_well(page, data);
}

}  // namespace palpate::tools::demo
