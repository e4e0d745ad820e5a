// What an arm, a tracker and a camera have said, kept and brought onto one time base: the host's.
//
// Samples come with the moment of the host's clock at which they arrived. Stamps become host time by the clocks' models, for which
// the whole recording was looked at; the smallest latency of each device stays in them (see ClockEstimator) and is calibrated as a
// delay elsewhere. Whether the samples come from devices or out of a recording makes no difference. Markers in World (= tracker); m,
// rad, s. Readings are those of arms of three joints; what other arms say is counted and left out of them. One thread.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "palpate/device/devices.h"
#include "palpate/time/clock_history.h"

namespace palpate::device {

// A marker's pose with the arm's readings at the same host time.
struct TrackedPose {
  double time_s = 0.0;  // host time
  TrackerSample marker;
  Vector3 joints = Vector3::Zero(), gimbal = Vector3::Zero();  // rad, uncorrected
};

struct ArmReading {
  double time_s = 0.0;  // host time
  Vector3 joints = Vector3::Zero(), gimbal = Vector3::Zero();
};

class DeviceStreams {
 public:
  // `waited` as of ClockEstimator. `keep` false: the sample only tells how its clock runs.
  void add(const ArmSample& sample, Instant<PhysicsClock> arrived, Duration waited = Duration(0),
           bool keep = true);
  void add(const TrackerSample& sample, Instant<PhysicsClock> arrived, Duration waited = Duration(0),
           bool keep = true);
  void add_image(Instant<CameraClock> mid_exposure, Instant<PhysicsClock> arrived,
                 Duration waited = Duration(0));
  // Forgets the samples, keeps the clocks.
  void clear();

  const std::vector<ArmSample>& arm() const { return arm_; }
  const std::vector<TrackerSample>& tracked() const { return tracked_; }
  double host_time(Instant<TrackerClock> stamp) const { return tracker_clock_.to(stamp).seconds(); }
  double host_time(Instant<CameraClock> stamp) const { return camera_clock_.to(stamp).seconds(); }

  // Without those that are no numbers: an arm that was silent for a moment.
  std::vector<ArmReading> arm_readings() const;
  // Seen poses of a marker, oldest first, with arm readings interpolated at their host time; poses outside the arm's readings, or
  // where those are more than 0.1 s apart, are left out.
  std::vector<TrackedPose> poses(MarkerId marker) const;
  // All there are of a marker, seen or not (marker.seen), without the arm's readings.
  std::vector<TrackedPose> marker_poses(MarkerId marker) const;
  int missed(MarkerId marker) const;  // frames in which it was not seen

  // How often a clock of theirs began anew. Times before that are not to be relied on.
  int restarts() const {
    return arm_clock_.restarts() + tracker_clock_.restarts() + camera_clock_.restarts();
  }
  std::uint64_t other_arms() const { return other_arms_; }  // samples of arms with more or fewer joints

 private:
  std::vector<ArmSample> arm_;
  std::vector<TrackerSample> tracked_;
  std::optional<Instant<TrackerClock>> last_stamp_;
  std::uint64_t arm_samples_ = 0, other_arms_ = 0;
  ClockHistory<ArmClock, PhysicsClock> arm_clock_;
  ClockHistory<TrackerClock, PhysicsClock> tracker_clock_;
  ClockHistory<CameraClock, PhysicsClock> camera_clock_;
};

// The marker at `time_s` between its neighbours there, rotation along the shortest arc; nothing where one of them was not seen,
// where they are further apart than `longest_gap_s`, or outside of the poses. `poses` as of marker_poses(). The covariance is that of
// the interpolated pose for neighbours whose noise is independent.
std::optional<TrackedPose> pose_between(const std::vector<TrackedPose>& poses, double time_s,
                                        double longest_gap_s = 0.1);

}  // namespace palpate::device
