// The demo report's last part: how everything was measured, and how to do it again.
#include <array>

#include "tools/demo/demo_sections.h"

namespace palpate::tools::demo {

void add_how_section(evaluation::report::Report& page, const figures::PlayFolder& data) {
  page.section("How it was measured, and how to do it again", "how");
  page.paragraph(
      "The simulated laboratory owns the truth: where everything is, what each clock shows, how each device "
      "errs. The two servers get what real devices would give them: encoder readings, marker poses, pixels, "
      "stamps of three clocks that disagree. Errors to truth are computed afterwards from both. A verdict "
      "compares a figure with the bar named beside it; a figure without a bar is only shown.");
  page.paragraph(
      "The same seed gives the same lock-step run to the last bit. `recompute.py` in the project's `tests` "
      "folder computes the errors again from the files below, sharing no code with the program:");
  const auto seed = data.number("seed");
  page.code(data.text("command").value_or(seed ? fmt::format("palpate demo --seed {:.0f}", *seed)
                                               : "palpate demo") +
            "\npython3 tests/recompute.py palpate-report");
  const std::array<std::pair<const char*, const char*>, 22> known{{
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
      {"touch.csv", "touch, millisecond by millisecond of contact"},
      {"haptics.csv", "forces asked for and given while there were any"},
      {"realtime_frames.csv", "the real-time leg, frame by frame"},
      {"realtime_sync.csv", "clock difference, estimated and true"},
      {"realtime_jitter.csv", "how often ticks of haptic and physics loop began how late"},
      {"realtime_loops.csv", "clients and loops of the physics server, fifty times a second"},
      {"realtime_poses.csv", "what each picture of the leg was drawn with, and its overlay errors"},
      {"realtime_truth.csv", "what was true when the leg's images were taken"},
      {"realtime_photons.csv", "the delay from light to light, picture by picture, and the truth beside it"},
      {"realtime_network.csv", "two hosts: what happened when"},
  }};
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, what] : known) {
    if (const CsvTable* table = data.raw(name))
      rows.push_back({fmt::format("`raw/{}`", name), fmt::format("{}", table->rows.size()), what});
  }
  if (!rows.empty()) page.table({"File beside this page", "rows", "what it holds"}, rows);
}

}  // namespace palpate::tools::demo
