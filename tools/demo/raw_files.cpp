#include "tools/demo/raw_files.h"

#include <algorithm>
#include <string_view>

#include "palpate/haptics/trip_writer.h"

namespace palpate::tools::demo {
namespace {

std::vector<scene::PlayTable> all_files() {
  std::vector<scene::PlayTable> files{
      {"arm_calibration.csv", "joint angles and marker poses the arm was calibrated from"},
      {"arm_held_out.csv", "the same of poses that no calibration has seen"},
      {"arm_poses.csv", "readings at which the methods are held against the truth"},
      {"arm_errors.csv", "each method's error to truth at those readings"},
      {"arm_guidance.csv", "predicted error of the arm against the number of poses"},
      {"pivot.csv", "marker poses while the stylus' tip was held"},
      {"pointer_pivot.csv", "marker poses while the pointer's tip was held"},
      {"corners.csv", "corners of the calibration board in the pictures"},
      {"hand.csv", "the head's marker, as the tracker saw it"},
      {"eye.csv", "the board, as the camera saw it"},
      {"surface.csv", "corners of table and wall, touched with the pointer"},
      {"touches.csv", "the same, and the landmarks on them"},
      {"lens.csv", "the lens, estimated and true"},
      {"lens_right.csv", "the right eye's lens"},
      {"estimates.json", "what the calibrations found"},
      {"truth.json", "what was true instead"},
      {"frames.csv", "what the graphics server believed in each frame"},
      {"frames_right.csv", "the same of the right eye"},
      {"truth_frames.csv", "what was true in each frame"},
      {"truth_frames_right.csv", "the same of the right eye"},
      {"check_points.csv", "points on table and wall that hold the overlay to account"},
      {"haptics.csv", "forces asked for and given while there were any"},
      {"realtime_frames.csv", "the real-time run, frame by frame"},
      {"realtime_poses.csv", "what each picture of the run was drawn with, and its overlay errors"},
      {"realtime_truth.csv", "what was true when the run's images were taken"},
      {"realtime_sync.csv", "clock difference, estimated and true"},
      {"realtime_jitter.csv", "how often ticks of haptic and physics loop began how late"},
      {"realtime_loops.csv", "clients and loops of the physics server, fifty times a second"},
      {"realtime_trips.csv",
       "when forces were taken from the hand, why, for how long, and the impulse it did not get"},
      {"realtime_photons.csv", "the delay from light to light, picture by picture, and the truth beside it"},
      {"realtime_predictions.csv",
       "predicted pictures: how far each thing was shown from where it was when the light left"},
      {"realtime_network.csv", "two hosts: what happened when"},
      {"headset_head.csv", "the head, as the headset tracks it"},
      {"headset_camera.csv", "the camera, at each picture that went to the headset"}};
  for (int i = 1; i <= haptics::TripWriter::kMostFiles; ++i)
    files.push_back({fmt::format("trip_{}.csv", i), "the seconds before an outage or a trip, tick by tick"});
  return files;
}

}  // namespace

const std::vector<scene::PlayTable>& raw_files() {
  static const std::vector<scene::PlayTable> files = all_files();
  return files;
}

Json files_of(const figures::PlayFolder& play, const scene::ApplicationSpec* application) {
  std::vector<scene::PlayTable> files = raw_files();
  const auto real_time = std::find_if(files.begin(), files.end(),
                                      [](const auto& one) { return one.file.starts_with("realtime_"); });
  if (application != nullptr) files.insert(real_time, application->tables.begin(), application->tables.end());
  const auto known = [&files](std::string_view name) {
    return std::any_of(files.begin(), files.end(), [&](const auto& one) { return one.file == name; });
  };
  const auto rows_of = [&play](std::string_view name) -> Json {
    for (const auto& [file, table] : play.tables())
      if (file == name) return table.rows.size();
    return nullptr;
  };
  for (const auto& [name, table] : play.tables())
    if (!known(name)) files.push_back({name, ""});
  Json there = Json::array();
  for (const auto& [name, holds] : files)
    if (play.has("raw/" + name))
      there.push_back({{"file", name}, {"table_rows", rows_of(name)}, {"holds", holds}});
  return there;
}

Json files_beside(const figures::PlayFolder& play) {
  const std::vector<scene::PlayTable> files{
      {"rig.toml", "what the calibrations found; the servers take it with `--rig rig.toml`"},
      {"world.toml", "the simulated laboratory, with everything that was true"},
      {"summary.json", "every figure of this page and more, and what made them"},
      {"report.json", "what this page is made of, curves and verdicts too"},
      {"video.mp4", "the play as the player saw it"}};
  Json there = Json::array();
  for (const auto& [file, holds] : files)
    if (play.has(file) || file == "report.json") there.push_back({{"file", file}, {"holds", holds}});
  if (!play.pictures("pictures").empty())
    there.push_back({{"file", "pictures/"}, {"holds", "the play's pictures, in full size"}});
  return there;
}

}  // namespace palpate::tools::demo
