// Clocks as a recorder learns them on a machine that holds it up at any place: between its looks, before a device is asked and
// after.
#include "palpate/calibration/session/recorder.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/random.h"
#include "palpate/time/clock.h"

namespace palpate::calibration::session {
namespace {

constexpr double kTrackerEvery = 0.01, kOnItsWay = 0.010, kTrackerAhead = 42.0, kArmAhead = 7.0;  // s

class Busy : public device::ArmDevice, public device::TrackerDevice, public device::Person {
 public:
  explicit Busy(VirtualClock<PhysicsClock>& clock) : clock_(clock) {}

  // One time in fifty the machine does something else for up to 12 ms.
  void hold_up() {
    if (random_.uniform(0.0, 1.0) < 0.02) clock_.advance(seconds(random_.uniform(0.0, 0.012)));
    clock_.advance(std::chrono::microseconds(2));
  }
  device::ArmSample read() override {
    hold_up();
    device::ArmSample sample;
    const double made = 1e-3 * std::floor(1e3 * clock_.now().seconds());
    sample.stamp = Instant<ArmClock>::from_seconds(made + kArmAhead);
    sample.waited = seconds(clock_.now().seconds() - made);
    hold_up();
    return sample;
  }
  std::vector<device::TrackerSample> poll() override {
    hold_up();
    std::vector<device::TrackerSample> samples;
    for (; next_ + kOnItsWay <= clock_.now().seconds(); next_ += kTrackerEvery) {
      device::TrackerSample& sample = samples.emplace_back();
      sample.stamp = Instant<TrackerClock>::from_seconds(next_ + kTrackerAhead);
      sample.seen = true;
      sample.translation.x() = next_;  // what time it was
      sample.waited = seconds(clock_.now().seconds() - next_ - kOnItsWay);
    }
    hold_up();
    return samples;
  }
  void command(const Vector3&) override {}
  void let_go() noexcept override {}
  Expected<void> ask(const device::Request&) override { return {}; }
  Expected<bool> ready() override { return true; }

 private:
  VirtualClock<PhysicsClock>& clock_;
  Random random_{6, "busy"};
  double next_ = 100.0;
};

TEST(Recorder, ClocksDoNotHoldWhereItWasHeldUp) {
  VirtualClock<PhysicsClock> clock(Instant<PhysicsClock>::from_seconds(100.0));
  Busy busy(clock);
  Recorder recorder({clock, busy, busy, nullptr, busy});
  for (int i = 0; i < 100; ++i) {
    recorder.run(0.1);
    clock.advance(seconds(0.137));  // looks for a board
  }
  const auto poses = recorder.poses(device::MarkerId::tip_marker);
  ASSERT_GT(poses.size(), 800u);
  for (const auto& pose : poses)
    ASSERT_NEAR(pose.time_s - pose.marker.translation.x(), kOnItsWay, 0.2e-3) << pose.time_s;
  const auto readings = recorder.arm_readings();
  ASSERT_GT(readings.size(), 5000u);
  for (std::size_t i = 0; i < readings.size(); ++i)
    ASSERT_NEAR(readings[i].time_s, std::round(1e3 * readings[i].time_s) * 1e-3, 0.2e-3) << i;
}

}  // namespace
}  // namespace palpate::calibration::session
