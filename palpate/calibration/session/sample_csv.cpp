#include "palpate/calibration/session/sample_csv.h"

#include <algorithm>

#include "palpate/core/csv.h"
#include "palpate/core/units.h"

namespace palpate::calibration::session {
namespace {

void append(std::vector<double>& row, const Vector3& v, double unit) {
  row.insert(row.end(), {v.x() * unit, v.y() * unit, v.z() * unit});
}
void append(std::vector<double>& row, const Quaternion& q) {
  row.insert(row.end(), {q.w(), q.x(), q.y(), q.z()});
}

const std::vector<std::string> kPoseColumns{"time_s", "x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz"};
const std::vector<std::string> kArmColumns{"joint_1_deg",  "joint_2_deg",  "joint_3_deg",
                                           "gimbal_1_deg", "gimbal_2_deg", "gimbal_3_deg"};

void append_arm(std::vector<double>& row, const TrackedPose& pose) {
  append(row, pose.joints, kDegreesPerRadian);
  append(row, pose.gimbal, kDegreesPerRadian);
}

std::string cell(double value) { return number_text(value); }

}  // namespace

std::string pivot_csv(const std::vector<TrackedPose>& poses, bool with_arm) {
  auto columns = kPoseColumns;
  if (with_arm) columns.insert(columns.end(), kArmColumns.begin(), kArmColumns.end());
  CsvWriter csv(columns);
  for (const auto& pose : poses) {
    std::vector<double> row{pose.time_s};
    append(row, pose.marker.translation, kMillimetresPerMetre);
    append(row, pose.marker.rotation);
    if (with_arm) append_arm(row, pose);
    csv.row(row);
  }
  return csv.content();
}

std::string arm_csv(const std::vector<TrackedPose>& poses, const Vector3& tip) {
  auto columns = kArmColumns;
  columns.insert(columns.end(), {"time_s", "marker_x_mm", "marker_y_mm", "marker_z_mm", "marker_qw",
                                 "marker_qx", "marker_qy", "marker_qz", "cov_xx_mm2", "cov_xy_mm2",
                                 "cov_xz_mm2", "cov_yy_mm2", "cov_yz_mm2", "cov_zz_mm2", "systematic_mm"});
  CsvWriter csv(columns);
  for (const auto& pose : poses) {
    std::vector<double> row;
    append_arm(row, pose);
    row.push_back(pose.time_s);
    append(row, pose.marker.translation, kMillimetresPerMetre);
    append(row, pose.marker.rotation);
    const Matrix3 c = pose.marker.point_covariance(tip) * (kMillimetresPerMetre * kMillimetresPerMetre);
    row.insert(row.end(), {c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2), c(2, 2),
                           std::sqrt(pose.marker.systematic.trace()) * kMillimetresPerMetre});
    csv.row(row);
  }
  return csv.content();
}

std::string points_csv(const std::vector<TouchedPoint>& touches) {
  CsvWriter csv({"label", "x_mm", "y_mm", "z_mm"});
  for (const auto& touch : touches)
    csv.row(std::vector<std::string>{touch.what + "_" + std::to_string(touch.index + 1),
                                     cell(touch.place.x() * 1e3), cell(touch.place.y() * 1e3),
                                     cell(touch.place.z() * 1e3)});
  return csv.content();
}

std::string corners_csv(const std::vector<vision::BoardView>& views) {
  CsvWriter csv({"image", "corner", "board_x_squares", "board_y_squares", "u_px", "v_px"});
  const double square = vision::BoardShape{}.square;
  for (const auto& view : views)
    for (std::size_t i = 0; i < view.image.size(); ++i)
      csv.row(std::vector<std::string>{view.name, cell(static_cast<double>(i)),
                                       cell(view.board[i].x() / square), cell(view.board[i].y() / square),
                                       cell(view.image[i].x()), cell(view.image[i].y())});
  return csv.content();
}

template <typename A, typename B>
std::string poses_csv(const std::vector<TimedPose<A, B>>& poses) {
  CsvWriter csv(kPoseColumns);
  for (const auto& pose : poses) {
    std::vector<double> row{pose.time_s};
    append(row, pose.pose.translation, kMillimetresPerMetre);
    append(row, pose.pose.rotation);
    csv.row(row);
  }
  return csv.content();
}

template std::string poses_csv(const std::vector<TimedPose<World, CameraMarker>>&);
template std::string poses_csv(const std::vector<TimedPose<Board, CameraOptical>>&);

std::vector<std::pair<std::string, std::string>> session_tables(const CalibrationRecordings& recordings,
                                                                const Vector3& tip) {
  std::vector<std::pair<std::string, std::string>> tables;
  const auto add = [&tables](const char* name, bool there, auto&& text) {
    if (there) tables.emplace_back(name, text());
  };
  add("pivot", !recordings.tip_pivot.empty(), [&] { return pivot_csv(recordings.tip_pivot, true); });
  add("pointer_pivot", !recordings.pointer_pivot.empty(),
      [&] { return pivot_csv(recordings.pointer_pivot, false); });
  const auto split =
      recordings.arm_poses.begin() +
      static_cast<std::ptrdiff_t>(std::min(recordings.arm_train.size(), recordings.arm_poses.size()));
  add("arm", split != recordings.arm_poses.begin(), [&] {
    return arm_csv({recordings.arm_poses.begin(), split}, tip);
  });
  add("arm_test", split != recordings.arm_poses.end(), [&] {
    return arm_csv({split, recordings.arm_poses.end()}, tip);
  });
  add("surface", !recordings.corners.empty(), [&] { return points_csv(recordings.corners); });
  add("landmarks", !recordings.landmark_touches.empty(),
      [&] { return points_csv(recordings.landmark_touches); });
  add("corners", !recordings.camera.lens_views.empty(),
      [&] { return corners_csv(recordings.camera.lens_views); });
  add("hand", !recordings.camera.hand.empty(), [&] { return poses_csv(recordings.camera.hand); });
  add("eye", !recordings.camera.eye.empty(), [&] { return poses_csv(recordings.camera.eye); });
  return tables;
}

}  // namespace palpate::calibration::session
