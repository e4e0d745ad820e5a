// What the driver says was commanded and not given, beside moments taken here before and after each command:
// bounds that hold however long a busy machine takes.
#include <gtest/gtest.h>

#include "drivers/openhaptics/stub_for_tests.h"
#include "palpate/time/clock.h"

namespace palpate::drivers::openhaptics {
namespace {

using Withheld = StubTest;

constexpr double kRounding = 1e-9;  // N s

double here_s() { return 1e-9 * static_cast<double>(MonotonicClock<ArmClock>::monotonic_ns()); }

void let_pass(OpenHapticsArm& arm, std::uint64_t cycles) {
  const auto before = arm.status().cycles;
  EXPECT_TRUE(comes_true([&] { return arm.status().cycles >= before + cycles; }));
}

TEST_F(Withheld, OfAForceThatIsHeldInFullNothingIs) {
  const auto arm = opened(patient());
  EXPECT_EQ(arm->read().withheld, Vector3(Vector3::Zero()));
  arm->command({1.0, 0.0, 0.0});
  EXPECT_TRUE(comes_true([&] { return force().x() == 1.0; }));
  let_pass(*arm, 2);
  const Vector3 ramp = arm->read().withheld;
  EXPECT_GT(ramp.x(), 0.0) << "the start ramp";
  let_pass(*arm, 30);
  EXPECT_NEAR((arm->read().withheld - ramp).norm(), 0.0, kRounding);
}

TEST_F(Withheld, OfForcesTheDeviceRefusesAllIs) {
  with([](HdStubDevice& d) {
    d.error = 0x0204;  // HD_FORCE_ERROR
    d.error_cycles = 1000000;
  });
  const auto arm = opened(patient());
  const double a = here_s();
  arm->command({0.0, 2.0, 0.0});
  const double b = here_s();
  let_pass(*arm, 30);
  const double c = here_s();
  arm->command(Vector3::Zero());
  const double d = here_s();
  let_pass(*arm, 3);
  const Vector3 withheld = arm->read().withheld;
  EXPECT_GE(withheld.y(), 2.0 * (c - b) - kRounding);
  EXPECT_LE(withheld.y(), 2.0 * (d - a) + kRounding);
  EXPECT_EQ(withheld.x(), 0.0);
  EXPECT_EQ(with([](HdStubDevice& device) { return device.largest_force; }), 0.0);
}

// The force is asked for in full in one cycle, and complained of: that cycle counts as not given.
TEST_F(Withheld, OfAForceThatIsRefusedOnceTheRefusedCycleIsToo) {
  with([](HdStubDevice& d) { d.true_force = 0.0; });
  auto settings = patient();
  settings.loop.ramp_s = 1e-6;
  settings.hold_s = 1000.0;
  const auto arm = opened(settings);
  let_pass(*arm, 3);
  const double a = here_s();
  arm->command({0.0, 5.0, 0.0});
  const double b = here_s();
  EXPECT_TRUE(comes_true([&] { return arm->status().force_errors == 1; }));
  let_pass(*arm, 3);
  const double c = here_s();
  arm->command(Vector3::Zero());
  const double d = here_s();
  let_pass(*arm, 3);
  const double withheld = arm->read().withheld.y();
  EXPECT_GE(withheld, 5.0 * (c - b) - kRounding);
  EXPECT_LE(withheld, 5.0 * (d - a) + kRounding);
}

TEST_F(Withheld, OfForcesAboveTheDevicesPeakWhatIsAboveIt) {
  with([](HdStubDevice& d) { d.nominal_force = d.true_force = 2.0; });
  const auto arm = opened(patient());
  const double a = here_s();
  arm->command({0.0, 0.0, 8.0});
  const double b = here_s();
  let_pass(*arm, 100);
  const double c = here_s();
  arm->command(Vector3::Zero());
  const double d = here_s();
  let_pass(*arm, 3);
  const double e = here_s();
  const double withheld = arm->read().withheld.z();
  EXPECT_GE(withheld, 8.0 * (c - b) - 2.0 * (e - a) - kRounding);
  EXPECT_LE(withheld, 8.0 * (d - a) + kRounding);
}

TEST_F(Withheld, OfForcesForADeviceThatIsGoneAllIs) {
  const auto arm = opened(patient());
  EXPECT_TRUE(comes_true([&] { return reads(*arm); }));
  with([](HdStubDevice& d) { d.plugged = false; });
  EXPECT_TRUE(comes_true([&] { return !arm->read().connected; }));
  const double a = here_s();
  arm->command({1.0, 0.0, 0.0});
  const double b = here_s();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const double c = here_s();
  arm->command(Vector3::Zero());
  const double d = here_s();
  EXPECT_GE(arm->read().withheld.x(), (c - b) - kRounding);
  EXPECT_LE(arm->read().withheld.x(), (d - a) + kRounding);
}

}  // namespace
}  // namespace palpate::drivers::openhaptics
