#include "palpate/calibration/session/sample_csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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

std::vector<std::string> arm_columns(const device::ArmModel& model) {
  const bool place = model.kind == device::ArmModel::Kind::cartesian;
  std::vector<std::string> columns =
      place ? std::vector<std::string>{"arm_x_mm", "arm_y_mm", "arm_z_mm"}
            : std::vector<std::string>{"joint_1_deg", "joint_2_deg", "joint_3_deg"};
  columns.insert(columns.end(), {"gimbal_1_deg", "gimbal_2_deg", "gimbal_3_deg"});
  return columns;
}

void append_arm(std::vector<double>& row, const TrackedPose& pose, const device::ArmModel& model) {
  append(row, pose.joints, device::reading_unit(model).per_si);
  append(row, pose.gimbal, kDegreesPerRadian);
}

std::string cell(double value) { return number_text(value); }

std::vector<double> pose_row(const TrackedPose& pose) {
  std::vector<double> row{pose.time_s};
  append(row, pose.marker.translation, kMillimetresPerMetre);
  append(row, pose.marker.rotation);
  return row;
}

// Upper triangle, row by row.
void append_upper(std::vector<double>& row, const Matrix3& m, double unit) {
  row.insert(row.end(), {m(0, 0) * unit, m(0, 1) * unit, m(0, 2) * unit, m(1, 1) * unit, m(1, 2) * unit,
                         m(2, 2) * unit});
}

constexpr double kMm2 = kMillimetresPerMetre * kMillimetresPerMetre;

}  // namespace

std::string pivot_csv(const std::vector<TrackedPose>& poses, bool with_arm, const std::vector<int>& segments,
                      const device::ArmModel& model) {
  auto columns = kPoseColumns;
  const auto of_arm = arm_columns(model);
  if (with_arm) columns.insert(columns.end(), of_arm.begin(), of_arm.end());
  if (!segments.empty()) columns.emplace_back("segment");
  CsvWriter csv(columns);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    auto row = pose_row(poses[i]);
    if (with_arm) append_arm(row, poses[i], model);
    if (!segments.empty()) row.push_back(segments.at(i));
    csv.row(row);
  }
  return csv.content();
}

std::string marker_csv(const std::vector<TrackedPose>& poses) {
  const std::vector<std::string> axes{"rx", "ry", "rz", "x", "y", "z"};
  const auto turns = [](std::size_t i) { return i < 3; };
  auto columns = kPoseColumns;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = i; j < 6; ++j)
      columns.push_back("cov_" + axes[i] + "_" + axes[j] +
                        (turns(j)   ? "_rad2"
                         : turns(i) ? "_rad_mm"
                                    : "_mm2"));
  for (const char* name : {"xx", "xy", "xz", "yy", "yz", "zz"})
    columns.push_back(fmt::format("sys_{}_mm2", name));
  CsvWriter csv(columns);
  for (const auto& pose : poses) {
    auto row = pose_row(pose);
    for (Eigen::Index i = 0; i < 6; ++i)
      for (Eigen::Index j = i; j < 6; ++j)
        row.push_back(pose.marker.covariance(i, j) * (i < 3 ? 1.0 : kMillimetresPerMetre) *
                      (j < 3 ? 1.0 : kMillimetresPerMetre));
    append_upper(row, pose.marker.systematic, kMm2);
    csv.row(row);
  }
  return csv.content();
}

std::string touches_csv(const std::vector<HeldTouch>& touches, const std::vector<std::string>& labels) {
  CsvWriter csv({"label", "x_mm", "y_mm", "z_mm", "std_x_mm", "std_y_mm", "std_z_mm", "frames", "time_s",
                 "seconds", "cov_xx_mm2", "cov_xy_mm2", "cov_xz_mm2", "cov_yy_mm2", "cov_yz_mm2",
                 "cov_zz_mm2"});
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const HeldTouch& touch = touches[i];
    std::vector<double> row;
    append(row, touch.place, kMillimetresPerMetre);
    append(row, touch.scatter.diagonal().cwiseSqrt(), kMillimetresPerMetre);
    row.insert(row.end(), {static_cast<double>(touch.frames), 0.5 * (touch.from_s + touch.to_s),
                           touch.to_s - touch.from_s});
    append_upper(row, touch.covariance, kMm2);
    std::vector<std::string> cells{labels.at(i)};
    for (const double value : row) cells.push_back(cell(value));
    csv.row(cells);
  }
  return csv.content();
}

std::string sights_csv(const std::vector<BoardSight>& sights) {
  auto columns = kPoseColumns;
  columns.insert(columns.end(), {"rms_px", "image"});
  CsvWriter csv(columns);
  for (const auto& sight : sights) {
    std::vector<double> row{sight.time_s};
    append(row, sight.pose.translation, kMillimetresPerMetre);
    append(row, sight.pose.rotation);
    row.push_back(sight.rms_px);
    std::vector<std::string> cells;
    for (const double value : row) cells.push_back(cell(value));
    cells.push_back(sight.image);
    csv.row(cells);
  }
  return csv.content();
}

std::string arm_csv(const std::vector<TrackedPose>& poses, const Vector3& tip,
                    const device::ArmModel& model) {
  auto columns = arm_columns(model);
  columns.insert(columns.end(), {"time_s", "marker_x_mm", "marker_y_mm", "marker_z_mm", "marker_qw",
                                 "marker_qx", "marker_qy", "marker_qz", "cov_xx_mm2", "cov_xy_mm2",
                                 "cov_xz_mm2", "cov_yy_mm2", "cov_yz_mm2", "cov_zz_mm2", "systematic_mm"});
  CsvWriter csv(columns);
  for (const auto& pose : poses) {
    std::vector<double> row;
    append_arm(row, pose, model);
    row.push_back(pose.time_s);
    append(row, pose.marker.translation, kMillimetresPerMetre);
    append(row, pose.marker.rotation);
    append_upper(row, pose.marker.point_covariance(tip), kMm2);
    row.push_back(std::sqrt(pose.marker.systematic.trace()) * kMillimetresPerMetre);
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

std::string corners_csv(const std::vector<vision::BoardView>& views, double square) {
  CsvWriter csv({"image", "corner", "board_x_squares", "board_y_squares", "u_px", "v_px"});
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
