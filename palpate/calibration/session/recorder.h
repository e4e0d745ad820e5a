// Keeps what the devices report while a procedure runs, and brings it into the host's time afterwards.
//
// tick() is one millisecond: wait, read the arm, poll the tracker. Stamps become host time as DeviceStreams has it. One thread.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "palpate/calibration/session/acquisition_context.h"
#include "palpate/device/device_streams.h"

namespace palpate::calibration::session {

using device::ArmReading;
using device::TrackedPose;

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
  double host_time(Instant<TrackerClock> stamp) const { return streams_.host_time(stamp); }
  const device::ArmSample& newest_arm() const { return streams_.arm().back(); }
  const std::vector<device::TrackerSample>& tracker_samples() const { return streams_.tracked(); }

  // As of DeviceStreams.
  std::vector<TrackedPose> poses(device::MarkerId marker) const { return streams_.poses(marker); }
  std::vector<ArmReading> arm_readings() const { return streams_.arm_readings(); }
  int missed(device::MarkerId marker) const { return streams_.missed(marker); }

 private:
  AcquisitionContext context_;
  std::function<void(const device::ArmSample&)> control_;
  std::optional<Instant<PhysicsClock>> next_, last_look_;
  device::DeviceStreams streams_;
};

}  // namespace palpate::calibration::session
