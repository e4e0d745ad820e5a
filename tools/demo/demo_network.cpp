// The demo report's part about two hosts and the cable between them, where the run was played on two.
#include <algorithm>
#include <array>
#include <cmath>

#include "tools/demo/demo_sections.h"

namespace palpate::tools::demo {
namespace {

figures::Level cable_out(const figures::PlayFolder& data) {
  const double at = data.number("realtime/network/cut_at_s").value_or(0.0);
  return {.at = at,
          .label = "cable out",
          .tone = figures::Tone::bad,
          .upright = true,
          .to = at + data.number("realtime/network/cut_for_s").value_or(0.0)};
}

// What happened when, in the order of time.
void add_events_section(evaluation::report::Report& page, const figures::PlayFolder& data, double pulled,
                        double out_for) {
  struct Event {
    double time_s;
    std::string since, what;
  };
  std::vector<Event> events{
      {pulled, "", "the cable is pulled out of the physics host"},
      {pulled + out_for, fmt::format("{:.2f} s later", out_for), "the cable is plugged in again"}};
  const auto add = [&](const char* key, double from, const char* after, const char* what) {
    if (const auto s = data.number(fmt::format("realtime/network/{}", key)))
      events.push_back({from + *s, fmt::format("{:.2f} s after {}", *s, after), what});
  };
  const char* pull = "the pull";
  const char* plug = "the plug";
  add("gone_after_s", pulled, pull,
      "graphics server: \u201cno longer answers\u201d; pictures go on with the last state");
  add("client_forgotten_after_s", pulled, pull,
      "physics server: no longer counts the graphics server as its client");
  add("back_after_s", pulled + out_for, plug,
      "graphics server: \u201canswers again\u201d, of its own accord");
  add("answers_after_s", pulled + out_for, plug, "physics server: has answered a question again");
  add("replies_after_s", pulled + out_for, plug, "the first picture drawn with its own state again");
  std::sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.time_s < b.time_s; });
  std::vector<std::vector<std::string>> rows;
  for (const auto& event : events)
    rows.push_back({event.what, fmt::format("{:.2f} s", event.time_s), event.since});
  page.table({"What happened", "at", ""}, rows);
}

void add_phases_section(evaluation::report::Report& page, const figures::PlayFolder& data) {
  const std::array<const char*, 3> phases{"before", "cut", "after"};
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](std::string label, const char* key, std::string_view unit) {
    std::vector<std::string> row{std::move(label)};
    for (const char* phase : phases)
      row.push_back(figures::shown(data.number(fmt::format("realtime/network/{}/{}", phase, key)), unit, 4));
    rows.push_back(std::move(row));
  };
  add("pictures drawn", "frames", "");
  add("of these without an answer of their own", "late", "");
  add("haptic loop: ticks", "haptic_ticks", "");
  add("haptic loop: overruns, still at work when the next tick was due", "haptic_overruns", "");
  add("haptic loop: ticks left out", "haptic_missed", "");
  add("physics loop: ticks", "physics_ticks", "");
  add("physics loop: overruns", "physics_overruns", "");
  add("physics loop: ticks left out", "physics_missed", "");
  add("clocks: largest error", "clock_error_us_max", "\u00b5s");
  add("clocks: largest uncertainty stated", "clock_uncertainty_us_max", "\u00b5s");
  add("clocks: share of pictures with the error within what was stated", "clock_inside_share", "");
  page.table({"", "before", "cable out", "after"}, rows);
}

// Each picture's round trip, or that there was none in time.
std::optional<figures::Plot> timeline_plot(const figures::PlayFolder& data) {
  const CsvTable* frames = data.raw("realtime_frames.csv");
  if (frames == nullptr || !figures::has_columns(*frames, {"time_s", "round_trip_us", "late"}))
    return std::nullopt;
  const auto time = figures::column(*frames, "time_s"), trip = figures::column(*frames, "round_trip_us"),
             late = figures::column(*frames, "late");
  double slowest = 0.0;
  for (std::size_t i = 0; i < time.size(); ++i)
    if (late[i] == 0.0 && std::isfinite(trip[i])) slowest = std::max(slowest, trip[i]);
  if (slowest <= 0.0) return std::nullopt;
  figures::Series answered{
      .name = "answer in time: its round trip", .mark = figures::Mark::points, .tone = figures::Tone::ours},
      without{.name = "no answer in time: drawn with the state before",
              .mark = figures::Mark::points,
              .tone = figures::Tone::bad};
  for (std::size_t i = 0; i < time.size(); ++i) {
    figures::Series& series = late[i] == 0.0 ? answered : without;
    series.x.push_back(time[i]);
    series.y.push_back(late[i] == 0.0 ? trip[i] : 2.0 * slowest);
  }
  figures::Plot plot{.title = "Every picture of the leg: how long its answer took",
                     .x_label = "s since the first picture",
                     .y_label = "round trip, \u00b5s",
                     .log_y = true};
  plot.series = {answered, without};
  plot.levels = {cable_out(data)};
  plot.caption =
      "A point per picture. Those in the row at the top had no answer when they were drawn; the row's height "
      "means nothing.";
  return plot;
}

std::optional<figures::Plot> clocks_plot(const figures::PlayFolder& data) {
  const CsvTable* sync = data.raw("realtime_sync.csv");
  if (sync == nullptr || !figures::has_columns(*sync, {"time_s", "offset_error_us", "uncertainty_us"}))
    return std::nullopt;
  const auto time = figures::column(*sync, "time_s"), error = figures::column(*sync, "offset_error_us"),
             sure = figures::column(*sync, "uncertainty_us");
  figures::Plot plot{.title = "Clocks: error of the estimated difference",
                     .x_label = "s since the first picture",
                     .y_label = "\u00b5s"};
  plot.series = {
      figures::band_around("stated uncertainty", time, std::vector<double>(time.size(), 0.0), sure),
      {.name = "error", .x = time, .y = error, .tone = figures::Tone::ours}};
  // The first moments, when little is known yet, would flatten everything after.
  std::vector<double> settled;
  for (std::size_t i = 0; i < time.size(); ++i)
    if (time[i] > 1.0) settled.push_back(std::max(sure[i], std::abs(error[i])));
  if (!settled.empty()) {
    const double most = 1.2 * *std::max_element(settled.begin(), settled.end());
    plot.y_range = {-most, most};
  }
  plot.levels = {cable_out(data)};
  plot.caption =
      "While nothing comes, the stated uncertainty grows by what the estimate of the drift leaves open. What "
      "was stated in the first second, before enough had been exchanged, may lie outside of the plot.";
  return plot;
}

std::optional<figures::Plot> loops_plot(const figures::PlayFolder& data) {
  const CsvTable* table = data.raw("realtime_loops.csv");
  if (table == nullptr || !figures::has_columns(*table, {"time_s", "haptic_ticks", "physics_ticks"}))
    return std::nullopt;
  const auto time = figures::column(*table, "time_s");
  figures::Plot plot{.title = "Haptic and physics loop",
                     .x_label = "s since the first picture",
                     .y_label = "ticks per second",
                     .from_zero = true};
  for (const auto& [name, key, tone] : {std::tuple("physics loop", "physics_ticks", figures::Tone::rival),
                                        std::tuple("haptic loop", "haptic_ticks", figures::Tone::ours)}) {
    const auto ticks = figures::column(*table, key);
    figures::Series rate{.name = name, .tone = tone};
    for (std::size_t i = 0, from = 0; i < time.size(); ++i) {
      if (time[i] - time[from] < 0.1) continue;
      if (time[from] >= 0.0) {
        rate.x.push_back(0.5 * (time[i] + time[from]));
        rate.y.push_back((ticks[i] - ticks[from]) / (time[i] - time[from]));
      }
      from = i;
    }
    plot.series.push_back(std::move(rate));
  }
  plot.y_range = {0.0, 1200.0};
  plot.levels = {cable_out(data)};
  plot.caption = "Over tenths of a second. Forces come from here, and go on without the network.";
  return plot;
}

}  // namespace

void add_network_section(evaluation::report::Report& page, const figures::PlayFolder& data) {
  const auto pulled = data.number("realtime/network/cut_at_s"),
             out_for = data.number("realtime/network/cut_for_s");
  if (!pulled || !out_for) return;
  const Json* told = data.find("realtime/network/encrypted");
  const bool encrypted = told != nullptr && told->is_boolean() && told->get<bool>();
  page.section("Two hosts, and a cable pulled", "two-hosts");
  page.paragraph(fmt::format(
      "For the part above, physics server and graphics server stood on two hosts: each had a network of its "
      "own (Linux network namespaces on one machine), joined by one cable. The graphics server at {} asked "
      "the physics server at {}{}. After {:.1f} s of play the cable was pulled, and {:.1f} s later it was "
      "plugged in again. Nobody helped: neither server was told, and neither was started anew.",
      data.text("realtime/network/graphics_place").value_or("one"),
      data.text("realtime/network/physics_address").value_or("the other"),
      encrypted ? ", encrypted, with keys made for this one run" : ", without encryption, as was asked for",
      *pulled, *out_for));
  page.paragraph(
      "What must hold: each side notices within a second, the hand's forces do not care, pictures go on with "
      "the state before, the clocks say how unsure they have become, and a second after the cable's return "
      "all is as it was.");
  std::vector<figures::Figure> figures;
  figures.push_back({"Connection", encrypted ? "encrypted" : "open",
                     encrypted ? "CURVE, a key for each side" : "", figures::Verdict::none});
  const auto within_a_second = [&](const char* key, std::string label, std::string note) {
    const auto s = data.number(fmt::format("realtime/network/{}", key));
    figures.push_back({std::move(label), s ? figures::shown(s, "s") : "never", std::move(note),
                       s ? figures::at_most(*s, 1.0) : figures::Verdict::falls_short});
  };
  within_a_second("gone_after_s", "Noticed after the pull", "at most 1 s");
  within_a_second("replies_after_s", "A picture with its own state after the plug", "at most 1 s");
  within_a_second("answers_after_s", "Physics server answers after the plug", "at most 1 s");
  const auto inside = data.number("realtime/network/cut/clock_inside_share");
  if (inside)
    figures.push_back({"Clock error within what was stated, cable out", figures::shown(100.0 * *inside, "%"),
                       "at least 99 % of pictures", figures::at_least(*inside, 0.99)});
  if (const auto lost = data.number("realtime/network/lost"))
    figures.push_back({"Questions lost", figures::shown(lost, "", 6), "sent, and no answer within 1 s",
                       figures::Verdict::none});
  if (const auto unsent = data.number("realtime/network/unsent"))
    figures.push_back({"Questions not sent", figures::shown(unsent, "", 6), "nobody was connected",
                       figures::Verdict::none});
  const auto repeated = data.number("realtime/network/repeated"),
             crossed = data.number("realtime/network/out_of_order");
  if (repeated && crossed)
    figures.push_back({"Answers twice, or out of order", fmt::format("{:.0f}, {:.0f}", *repeated, *crossed),
                       "", figures::Verdict::none});
  page.figures(figures);
  add_events_section(page, data, *pulled, *out_for);
  if (const auto plot = timeline_plot(data)) page.plot(*plot);
  std::vector<figures::Plot> plots;
  if (const auto plot = clocks_plot(data)) plots.push_back(*plot);
  if (const auto plot = loops_plot(data)) plots.push_back(*plot);
  if (!plots.empty()) page.plots(plots);
  add_phases_section(page, data);
}

}  // namespace palpate::tools::demo
