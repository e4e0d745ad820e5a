#include "palpate/calibration/session/sample_csv.h"

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

}  // namespace palpate::calibration::session
