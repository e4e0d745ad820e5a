// The demo report's last part: how everything was measured, and how to do it again.
#include <array>

#include "tools/demo/demo_sections.h"

namespace palpate::tools::demo {
namespace {

// Of the calibrations and the pictures; then come the application's, then the others.
constexpr std::array<std::pair<const char*, const char*>, 11> kFirstFiles{{
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
}};
constexpr std::array<std::pair<const char*, const char*>, 9> kLastFiles{{
    {"haptics.csv", "forces asked for and given while there were any"},
    {"realtime_frames.csv", "the real-time run, frame by frame"},
    {"realtime_sync.csv", "clock difference, estimated and true"},
    {"realtime_jitter.csv", "how often ticks of haptic and physics loop began how late"},
    {"realtime_loops.csv", "clients and loops of the physics server, fifty times a second"},
    {"realtime_poses.csv", "what each picture of the leg was drawn with, and its overlay errors"},
    {"realtime_truth.csv", "what was true when the leg's images were taken"},
    {"realtime_photons.csv", "the delay from light to light, picture by picture, and the truth beside it"},
    {"realtime_network.csv", "two hosts: what happened when"},
}};

}  // namespace

void add_how_section(evaluation::report::Report& page, const figures::PlayFolder& data,
                     const std::vector<scene::PlayTable>& tables) {
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
  std::vector<std::vector<std::string>> rows;
  const auto add = [&](const std::string& file, const std::string& holds) {
    if (const CsvTable* table = data.raw(file))
      rows.push_back({fmt::format("`raw/{}`", file), fmt::format("{}", table->rows.size()), holds});
  };
  for (const auto& [file, holds] : kFirstFiles) add(file, holds);
  for (const auto& table : tables) add(table.file, table.holds);
  for (const auto& [file, holds] : kLastFiles) add(file, holds);
  if (!rows.empty()) page.table({"File beside this page", "rows", "what it holds"}, rows);
}

}  // namespace palpate::tools::demo
