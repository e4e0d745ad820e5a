#include "palpate/server/graphics/pose_log.h"

#include "palpate/math/csv_cells.h"
#include "palpate/scene/shown_tip.h"
#include "palpate/server/graphics/record_names.h"

namespace palpate::server::graphics {

Expected<PoseLog> PoseLog::begin(const std::filesystem::path& folder) {
  auto rows =
      CsvFile::begin(folder / "realtime_poses.csv",
                     joined({{"frame", "camera_frame", "time_s"},
                             pose_columns("cam"),
                             point_columns("tip"),
                             {"late"},
                             pose_columns("tracker_cam"),
                             {"pose_source", "landmarks_used", "expected_world_px", "camera_stamp_ns"}}));
  if (!rows) return tl::unexpected(rows.error());
  return PoseLog(std::move(*rows));
}

void PoseLog::add(const FrameRecord& frame, const scene::SceneDescription& scene, double time_s) {
  Cells row{fmt::format("{}", frame.number), fmt::format("{}", frame.camera_frame)};
  put(row, time_s);
  put(row, frame.X_world_camera);
  if (frame.have_state)
    put(row, scene::shown_tip(frame.state, scene));
  else
    row.insert(row.end(), 3, "");
  row.emplace_back(frame.late ? "1" : "0");
  if (frame.have_tracker)
    put(row, frame.X_world_camera_tracker);
  else
    row.insert(row.end(), 7, "");
  row.emplace_back(pose_source_name(frame.pose_source));
  put(row, static_cast<double>(frame.landmarks_used));
  put(row, frame.expected_world_px);
  row.push_back(fmt::format("{}", frame.stamp.ns()));
  rows_.row(row);
}

}  // namespace palpate::server::graphics
