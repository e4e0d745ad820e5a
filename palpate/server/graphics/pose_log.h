// What the graphics server drew each picture with: its raw file realtime_poses.csv.
//
// Columns: frame, camera_frame (the camera's own count), time_s (since the server began to show pictures),
// cam_x_m ... cam_qz (the camera's pose that was drawn with, World), tip_x_m, tip_y_m, tip_z_m (the stylus
// tip as it was drawn; empty where no state was known), late (1: the reply was late, the previous state was
// drawn), tracker_cam_x_m ... tracker_cam_qz (by the tracker alone; empty where it was blind), pose_source,
// landmarks_used, expected_world_px (its own estimate of its overlay error), camera_stamp_ns (of the middle of the
// image's exposure, by the camera's own clock). One thread.
#pragma once

#include <filesystem>

#include "palpate/core/csv_file.h"
#include "palpate/core/expected.h"
#include "palpate/scene/application.h"
#include "palpate/server/graphics/frame_record.h"

namespace palpate::server::graphics {

class PoseLog {
 public:
  // In this folder.
  static Expected<PoseLog> begin(const std::filesystem::path& folder);
  void add(const FrameRecord& frame, const scene::SceneDescription& scene, double time_s);
  Expected<void> finish() { return rows_.finish(); }

 private:
  explicit PoseLog(CsvFile rows) : rows_(std::move(rows)) {}
  CsvFile rows_;
};

}  // namespace palpate::server::graphics
