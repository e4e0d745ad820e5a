// Keeps what the devices report while a procedure runs, and brings it into the host's time afterwards.
//
// tick() is one millisecond: wait, read the arm, poll the tracker, feed the clock estimators. Stamps become
// host time by the clock models at the end of the recording; the smallest latency of each device stays in
// them (see ClockEstimator) and is calibrated as a delay elsewhere. One thread.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "palpate/calibration/session/acquisition_context.h"
#include "palpate/time/clock_model.h"

namespace palpate::calibration::session {

// A marker's pose with the arm's readings at the same host time.
struct TrackedPose {
  double time_s = 0.0;  // host time
  device::TrackerSample marker;
  Vector3 joints = Vector3::Zero(), gimbal = Vector3::Zero();  // rad, uncorrected
};

struct ArmReading {
  double time_s = 0.0;  // host time
  Vector3 joints = Vector3::Zero(), gimbal = Vector3::Zero();
};

template <typename A, typename B>
struct TimedPose {
  double time_s = 0.0;
  Pose<A, B> pose;
};

class Recorder {
 public:
  explicit Recorder(AcquisitionContext laboratory) : context_(laboratory) {}

  // What to do with each arm reading within the tick (hold the tip); none by default.
  void set_control(std::function<void(const device::ArmSample&)> control) { control_ = std::move(control); }

  void tick();
  void run(double seconds_long);  // shorter where the session is stopped
  // Ticks until the person is ready. Refused: what the person says, or ErrorCode::timed_out.
  Expected<void> run_until_ready();
  // Forgets the samples, keeps the clocks.
  void clear();

  double now_s() const { return context_.clock.now().seconds(); }
  double host_time(Instant<TrackerClock> stamp) const { return tracker_clock_.model().to(stamp).seconds(); }
  const device::ArmSample& newest_arm() const { return arm_.back(); }
  const std::vector<device::TrackerSample>& tracker_samples() const { return tracked_; }

  // Seen poses of a marker, oldest first, with arm readings interpolated at their host time; poses outside
  // the recorded arm readings are left out.
  std::vector<TrackedPose> poses(device::MarkerId marker) const;
  std::vector<ArmReading> arm_readings() const;
  int missed(device::MarkerId marker) const;  // frames in which it was not seen

 private:
  AcquisitionContext context_;
  std::function<void(const device::ArmSample&)> control_;
  std::optional<Instant<PhysicsClock>> next_, last_look_;
  long ticks_ = 0;
  std::vector<device::ArmSample> arm_;
  std::vector<device::TrackerSample> tracked_;
  ClockEstimator<ArmClock, PhysicsClock> arm_clock_;
  ClockEstimator<TrackerClock, PhysicsClock> tracker_clock_;
};

}  // namespace palpate::calibration::session
