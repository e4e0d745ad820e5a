#include "palpate/device/device_streams.h"

#include <algorithm>

namespace palpate::device {
namespace {

constexpr double kLongestArmGap = 0.1;  // s between two readings of an arm that speaks every millisecond

}  // namespace

void DeviceStreams::add(const ArmSample& sample, Instant<PhysicsClock> arrived, Duration waited, bool keep) {
  if (sample.joints.size() != 3) ++other_arms_;
  // A hundred pairs a second are plenty for a clock.
  if (arm_samples_++ % 10 == 0) arm_clock_.add(sample.stamp, arrived, waited);
  if (keep) arm_.push_back(sample);
}

void DeviceStreams::add(const TrackerSample& sample, Instant<PhysicsClock> arrived, Duration waited,
                        bool keep) {
  // The bodies of one frame share a stamp; a clock wants each moment once.
  if (last_stamp_ != sample.stamp) tracker_clock_.add(sample.stamp, arrived, waited);
  last_stamp_ = sample.stamp;
  if (keep) tracked_.push_back(sample);
}

void DeviceStreams::add_image(Instant<CameraClock> mid_exposure, Instant<PhysicsClock> arrived,
                              Duration waited) {
  camera_clock_.add(mid_exposure, arrived, waited);
}

void DeviceStreams::clear() {
  arm_.clear();
  tracked_.clear();
}

std::vector<ArmReading> DeviceStreams::arm_readings() const {
  std::vector<ArmReading> readings;
  readings.reserve(arm_.size());
  for (const auto& sample : arm_)
    if (sample.joints.size() == 3 && sample.joints.allFinite() && sample.gimbal.allFinite())
      readings.push_back({arm_clock_.to(sample.stamp).seconds(), sample.joints, sample.gimbal});
  return readings;
}

std::vector<TrackedPose> DeviceStreams::poses(MarkerId marker) const {
  const auto readings = arm_readings();
  std::vector<TrackedPose> result;
  for (auto& pose : marker_poses(marker)) {
    if (!pose.marker.seen) continue;
    const double t = pose.time_s;
    const auto after =
        std::lower_bound(readings.begin(), readings.end(), t,
                         [](const ArmReading& reading, double when) { return reading.time_s < when; });
    if (after == readings.begin() || after == readings.end()) continue;
    const auto before = after - 1;
    if (after->time_s - before->time_s > kLongestArmGap) continue;
    const double s = (t - before->time_s) / (after->time_s - before->time_s);
    pose.joints = before->joints + s * (after->joints - before->joints);
    pose.gimbal = before->gimbal + s * (after->gimbal - before->gimbal);
    result.push_back(std::move(pose));
  }
  return result;
}

std::vector<TrackedPose> DeviceStreams::marker_poses(MarkerId marker) const {
  std::vector<TrackedPose> result;
  for (const auto& sample : tracked_)
    if (sample.marker == marker)
      result.push_back({host_time(sample.stamp), sample, Vector3::Zero(), Vector3::Zero()});
  // Packets of a network overtake each other.
  const auto earlier = [](const TrackedPose& a, const TrackedPose& b) { return a.time_s < b.time_s; };
  if (!std::is_sorted(result.begin(), result.end(), earlier))
    std::stable_sort(result.begin(), result.end(), earlier);
  return result;
}

int DeviceStreams::missed(MarkerId marker) const {
  return static_cast<int>(std::count_if(tracked_.begin(), tracked_.end(), [&](const TrackerSample& sample) {
    return sample.marker == marker && !sample.seen;
  }));
}

std::optional<TrackedPose> pose_between(const std::vector<TrackedPose>& poses, double time_s,
                                        double longest_gap_s) {
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), time_s,
                       [](const TrackedPose& pose, double when) { return pose.time_s < when; });
  if (after == poses.end()) return std::nullopt;
  if (after->time_s == time_s) return after->marker.seen ? std::optional(*after) : std::nullopt;
  if (after == poses.begin()) return std::nullopt;
  const TrackedPose &a = *(after - 1), &b = *after;
  if (!a.marker.seen || !b.marker.seen || b.time_s - a.time_s > longest_gap_s) return std::nullopt;
  const double s = (time_s - a.time_s) / (b.time_s - a.time_s);
  TrackedPose between = s < 0.5 ? a : b;
  between.time_s = time_s;
  between.marker.stamp = a.marker.stamp + seconds(s * to_seconds(b.marker.stamp - a.marker.stamp));
  between.marker.rotation = a.marker.rotation.slerp(s, b.marker.rotation);
  between.marker.translation = (1.0 - s) * a.marker.translation + s * b.marker.translation;
  between.marker.covariance = (1.0 - s) * (1.0 - s) * a.marker.covariance + s * s * b.marker.covariance;
  between.marker.systematic = (1.0 - s) * a.marker.systematic + s * b.marker.systematic;
  between.joints = (1.0 - s) * a.joints + s * b.joints;
  between.gimbal = (1.0 - s) * a.gimbal + s * b.gimbal;
  return between;
}

}  // namespace palpate::device
