// The demo report's last part: the leg against the wall clock, how everything was measured, and how to do it
// again.
#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/report/demo_sections.h"

namespace palpate::report {

void tell_real_time(Report& page, const DemoData& data) {
  if (data.find("realtime") == nullptr) return;
  std::vector<Figure> figures;
  const auto add = [&](std::string_view path, std::string label, std::string_view unit, std::string note,
                       std::optional<double> bar = std::nullopt) {
    const auto value = data.number(path);
    if (!value) return;
    figures.push_back(
        {std::move(label), shown(value, unit), std::move(note), bar ? at_most(*value, *bar) : Verdict::none});
  };
  add("realtime/exchange/round_trip_us/median", "Round trip, median", "\u00b5s",
      "the 2006 paper: 300 to 800 \u00b5s");
  add("realtime/exchange/round_trip_us/p99", "Round trip, 99 % below", "\u00b5s", "");
  if (const auto late = data.number("realtime/exchange/late"),
      frames = data.number("realtime/exchange/frames");
      late && frames) {
    figures.push_back({"Late answers", fmt::format("{:.0f} of {:.0f}", *late, *frames), "", Verdict::none});
  }
  add("realtime/sync/offset_error_us_p99", "Clocks agree, 99 % within", "\u00b5s", "at most 50 \u00b5s",
      50.0);
  add("realtime/sync/uncertainty_us", "Uncertainty it states itself", "\u00b5s", "");
  if (const auto rate = data.number("realtime/haptic/rate_hz"))
    figures.push_back({"Haptic loop", shown(*rate, "Hz"), "at least 990 Hz of 1000", at_least(*rate, 990.0)});
  add("realtime/haptic/overruns", "Haptic overruns", "", "ticks still at work when the next was due");
  add("realtime/haptic/missed", "Haptic ticks left out", "", "the machine gave the loop no time for them");
  add("realtime/haptic/jitter_us/p99", "Haptic jitter, 99 % below", "\u00b5s", "");
  if (const auto lost = data.number("realtime/force/lost_impulse_rel"))
    figures.push_back({"Impulse the hand did not get", shown(100.0 * *lost, "%"),
                       "at most 1 %; more where ticks were left out during a blow", at_most(*lost, 0.01)});
  add("realtime/physics/rate_hz", "Physics loop", "Hz", "");
  add("realtime/graphics/rate_hz", "Pictures", "Hz",
      "as fast as this machine draws two pictures, the camera's and ours");
  if (figures.empty()) return;
  page.section("Against the wall clock", "real-time");
  page.paragraph(
      "Everything above ran in lock-step on a virtual clock, so that no figure depends on how quick the "
      "machine is. This "
      "part ran in real "
      "time: world, physics server and graphics server as three processes, the last one's clock disguised "
      "with an offset and a drift. Its "
      "figures belong to "
      "the machine it ran on.");
  page.figures(figures);
  std::vector<Plot> plots;
  const CsvTable* frames = data.raw("realtime_frames.csv");
  if (frames != nullptr && frames->has("round_trip_us")) {
    const auto trips = column(*frames, "round_trip_us");
    const double most = quantile(trips, 0.99) * 1.25;
    if (most > 0.0) {
      Plot plot{.title = "Round trips", .x_label = "\u00b5s", .y_label = "frames"};
      plot.series = {histogram("round trip", trips, 0.0, most, 50)};
      plot.series.front().in_legend = false;
      plot.levels.push_back(
          {.at = quantile(trips, 0.5), .label = "median", .tone = Tone::rival, .upright = true});
      plot.caption = "The outermost column also counts everything slower.";
      plots.push_back(plot);
    }
  }
  const CsvTable* sync = data.raw("realtime_sync.csv");
  if (sync != nullptr && has_columns(*sync, {"time_s", "offset_error_us", "uncertainty_us"})) {
    const auto time = column(*sync, "time_s"), error = column(*sync, "offset_error_us"),
               sure = column(*sync, "uncertainty_us");
    const Series band = band_around("stated uncertainty", time, std::vector<double>(time.size(), 0.0), sure);
    Plot plot{.title = "Clock difference, estimate against truth", .x_label = "s", .y_label = "\u00b5s"};
    plot.series = {band, {.name = "error", .x = time, .y = error, .tone = Tone::ours}};
    plots.push_back(plot);
  }
  if (!plots.empty()) page.plots(plots);
}

void tell_how(Report& page, const DemoData& data) {
  page.section("How it was measured, and how to do it again", "how");
  page.paragraph(
      "The simulated laboratory owns the truth: where everything is, what each clock shows, how each device "
      "errs. The "
      "two servers get what real devices would give them: encoder readings, marker poses, pixels, stamps of "
      "three clocks "
      "that disagree. Errors to truth are computed afterwards from both. A verdict compares a figure with "
      "the bar named "
      "beside it; a figure without a bar is only shown.");
  page.paragraph(
      "The same seed gives the same lock-step run to the last bit. `recompute.py` in the project's `tests` "
      "folder computes "
      "the errors again from the files below, sharing no code with the program:");
  const auto seed = data.number("seed");
  page.code(data.text("command").value_or(seed ? fmt::format("palpate demo --seed {:.0f}", *seed)
                                               : "palpate demo") +
            "\npython3 tests/recompute.py palpate-report");
  const std::array<std::pair<const char*, const char*>, 17> known{{
      {"arm_calibration.csv", "joint angles and marker poses the arm was calibrated from"},
      {"arm_errors.csv", "each method's error to truth at 1000 poses"},
      {"pivot.csv", "marker poses while the tip was held"},
      {"corners.csv", "corners of the calibration board in the pictures"},
      {"hand.csv", "the head's marker, as the tracker saw it"},
      {"eye.csv", "the board, as the camera saw it"},
      {"surface.csv", "corners of table and wall, touched with the pointer"},
      {"lens.csv", "the lens, estimated and true"},
      {"frames.csv", "what the graphics server believed in each frame"},
      {"truth_frames.csv", "what was true in each frame"},
      {"check_points.csv", "points on table and wall that hold the overlay to account"},
      {"ball.csv", "the ball, frame by frame"},
      {"haptics.csv", "forces asked for and given around the hits"},
      {"realtime_frames.csv", "the real-time leg, frame by frame"},
      {"realtime_sync.csv", "clock difference, estimated and true"},
      {"realtime_loops.csv", "clients and loops of the physics server, fifty times a second"},
      {"realtime_network.csv", "two hosts: what happened when"},
  }};
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, what] : known) {
    if (const CsvTable* table = data.raw(name))
      rows.push_back({fmt::format("`raw/{}`", name), fmt::format("{}", table->rows.size()), what});
  }
  if (!rows.empty()) page.table({"File beside this page", "rows", "what it holds"}, rows);
}

}  // namespace palpate::report
