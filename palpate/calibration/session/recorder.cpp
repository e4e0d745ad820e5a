#include "palpate/calibration/session/recorder.h"

#include <algorithm>

namespace palpate::calibration::session {
namespace {
constexpr Duration kTick = std::chrono::milliseconds(1);
}

void Recorder::tick() {
  const auto now = context_.clock.now();
  if (!next_ || *next_ < now) next_ = now;
  *next_ += kTick;
  context_.clock.sleep_until(*next_);
  const auto read_at = context_.clock.now();
  const Duration waited = read_at - last_look_.value_or(read_at);
  last_look_ = read_at;
  const device::ArmSample arm = context_.arm.read();
  if (control_) control_(arm);
  // A hundred pairs a second are plenty for a clock.
  if (ticks_++ % 10 == 0) arm_clock_.add(arm.stamp, read_at, waited);
  arm_.push_back(arm);
  const auto tracked = context_.tracker.poll();
  context_.person.watch(read_at.seconds(), arm, tracked);
  for (const auto& sample : tracked) {
    // The bodies of one frame share a stamp; a clock estimator wants each moment once.
    if (tracked_.empty() || sample.stamp != tracked_.back().stamp)
      tracker_clock_.add(sample.stamp, read_at, waited);
    tracked_.push_back(sample);
  }
}

void Recorder::run(double seconds_long) {
  const auto end = context_.clock.now() + seconds(seconds_long);
  while (context_.clock.now() < end && !context_.stopped()) tick();
}

Expected<void> Recorder::run_until_ready() {
  const auto patience = context_.person.patience();
  const auto began = context_.clock.now();
  while (true) {
    const auto ready = context_.person.ready();
    if (!ready) return tl::unexpected(ready.error());
    if (*ready) return {};
    if (context_.stopped()) return refused(ErrorCode::stopped, "stopped");
    if (patience && context_.clock.now() >= began + seconds(*patience))
      return refused(ErrorCode::timed_out, "not begun within {} s; start again when you are ready",
                     *patience);
    tick();
  }
}

void Recorder::clear() {
  arm_.clear();
  tracked_.clear();
}

std::vector<ArmReading> Recorder::arm_readings() const {
  const auto model = arm_clock_.model();
  std::vector<ArmReading> readings;
  readings.reserve(arm_.size());
  // Readings that are not numbers are those of an arm that was silent for a moment.
  for (const auto& sample : arm_)
    if (sample.joints.allFinite() && sample.gimbal.allFinite())
      readings.push_back({model.to(sample.stamp).seconds(), sample.joints, sample.gimbal});
  return readings;
}

std::vector<TrackedPose> Recorder::poses(device::MarkerId marker) const {
  const auto readings = arm_readings();
  const auto model = tracker_clock_.model();
  std::vector<TrackedPose> result;
  for (const auto& sample : tracked_) {
    if (sample.marker != marker || !sample.seen) continue;
    const double t = model.to(sample.stamp).seconds();
    const auto after =
        std::lower_bound(readings.begin(), readings.end(), t,
                         [](const ArmReading& reading, double when) { return reading.time_s < when; });
    if (after == readings.begin() || after == readings.end()) continue;
    const auto before = after - 1;
    const double s = (t - before->time_s) / (after->time_s - before->time_s);
    result.push_back({t, sample, before->joints + s * (after->joints - before->joints),
                      before->gimbal + s * (after->gimbal - before->gimbal)});
  }
  return result;
}

int Recorder::missed(device::MarkerId marker) const {
  return static_cast<int>(std::count_if(
      tracked_.begin(), tracked_.end(),
      [&](const device::TrackerSample& sample) { return sample.marker == marker && !sample.seen; }));
}

}  // namespace palpate::calibration::session
