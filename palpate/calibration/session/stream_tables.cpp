#include "palpate/calibration/session/stream_tables.h"

#include <algorithm>

#include "palpate/calibration/pivot_rests.h"
#include "palpate/calibration/session/sample_csv.h"
#include "palpate/device/marker_names.h"

namespace palpate::calibration::session {
namespace {

constexpr std::size_t kFewestHolds = 10;  // fewer say nothing of an arm

std::optional<device::MarkerId> marker_of_table(const std::string& name) {
  if (name == "pivot") return device::MarkerId::tip_marker;
  if (name == "pointer_pivot") return device::MarkerId::pointer;
  if (name == "hand") return device::MarkerId::camera_marker;
  return std::nullopt;
}

Expected<std::string> arm_table(const device::DeviceStreams& streams, const Vector3& tip,
                                const device::ArmModel& model) {
  auto poses = still_arm_poses(streams);
  if (poses.size() < kFewestHolds) poses = streams.poses(device::MarkerId::tip_marker);
  if (poses.empty())
    return refused("there are {} arm readings and {} poses of the tip marker, none of both at one time",
                   streams.arm().size(),
                   seen_poses(streams.marker_poses(device::MarkerId::tip_marker)).size());
  return arm_csv(poses, tip, model);
}

}  // namespace

std::vector<TrackedPose> seen_poses(const std::vector<TrackedPose>& poses) {
  std::vector<TrackedPose> seen;
  for (const auto& pose : poses)
    if (pose.marker.seen) seen.push_back(pose);
  return seen;
}

std::vector<TrackedPose> still_arm_poses(const device::DeviceStreams& streams, const HoldSettings& settings) {
  const auto joined = streams.poses(device::MarkerId::tip_marker);
  std::vector<TrackedPose> still;
  for (const auto& hold : find_holds(streams.marker_poses(device::MarkerId::tip_marker), settings)) {
    Hold with_readings;
    for (const auto& pose : hold) {
      const auto at = std::lower_bound(joined.begin(), joined.end(), pose.time_s,
                                       [](const TrackedPose& one, double when) { return one.time_s < when; });
      if (at != joined.end() && at->time_s == pose.time_s) with_readings.push_back(*at);
    }
    if (with_readings.size() >= settings.fewest) still.push_back(mean_pose(with_readings));
  }
  return still;
}

Expected<std::vector<int>> pivot_segments(const std::vector<TrackedPose>& poses) {
  std::vector<PivotPose> pivot;
  for (const auto& pose : poses)
    pivot.push_back({pose.marker.rotation, pose.marker.translation, 0, std::nullopt, pose.time_s});
  const auto rests = find_pivot_rests(pivot);
  if (!rests) return tl::unexpected(rests.error());
  put_segments(*rests, pivot);
  std::vector<int> segments;
  for (const auto& pose : pivot) segments.push_back(pose.segment + 1);
  return segments;
}

Expected<std::string> table_from_streams(const device::DeviceStreams& streams, const std::string& name,
                                         const Vector3& tip, const device::ArmModel& model) {
  if (name == "arm") return arm_table(streams, tip, model);
  const auto marker = marker_of_table(name);
  if (!marker) return refused("a table '{}' is not made of raw streams", name);
  const bool with_arm = name == "pivot" && !streams.arm_readings().empty();
  const auto poses = with_arm ? streams.poses(*marker) : seen_poses(streams.marker_poses(*marker));
  if (poses.empty()) return refused("no pose of {} is there", device::name_of_marker(*marker));
  return pivot_csv(poses, with_arm, {}, model);
}

}  // namespace palpate::calibration::session
