#include "palpate/physics_server/arm_source.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "palpate/drivers/openhaptics/stub_for_tests.h"
#include "palpate/haptics/haptic_loop.h"

namespace palpate {
namespace {

using openhaptics::comes_true;

class RealArm : public openhaptics::StubTest {
 protected:
  RealArm() { setenv("PALPATE_LIBHD", openhaptics::kStub, 1); }
  ~RealArm() override { unsetenv("PALPATE_LIBHD"); }
};

TEST_F(RealArm, IsChosenByNameAndOtherChoicesAreWrongUse) {
  ArmChoice choice;
  choice.text = "openhaptics:Right";
  auto arm = open_arm(choice);
  ASSERT_TRUE(arm) << arm.error().message;
  EXPECT_TRUE(with([](HdStubDevice& d) { return d.open; }, 2));
  for (const char* text : {"", "openhaptics:", "openhaptic", "phantom", "openhapticsRight"}) {
    choice.text = text;
    const auto refusal = open_arm(choice);
    ASSERT_FALSE(refusal) << text;
    EXPECT_EQ(refusal.error().exit_code(), 2);
    EXPECT_NE(refusal.error().message.find("openhaptics:NAME"), std::string::npos);
  }
}

TEST_F(RealArm, LowersTheForceLimitsToItsOwnAndNeverRaisesThem) {
  with([](HdStubDevice& d) {
    d.nominal_force = 3.3;
    d.nominal_continuous = 0.9;
  });
  ArmChoice choice;
  choice.text = "openhaptics";
  {
    const auto arm = open_arm(choice);
    ASSERT_TRUE(arm);
    EXPECT_EQ((*arm)->limits({}).peak_n, 3.3);
    EXPECT_EQ((*arm)->limits({}).continuous_n, 0.9);
  }
  with([](HdStubDevice& d) {
    d.nominal_force = 37.5;
    d.nominal_continuous = 6.2;
  });
  const auto arm = open_arm(choice);
  ASSERT_TRUE(arm);
  EXPECT_EQ((*arm)->limits({}).peak_n, ForceLimits().peak_n);
  EXPECT_EQ((*arm)->limits({}).continuous_n, ForceLimits().continuous_n);
}

TEST_F(RealArm, TellsOnceWhoItIsThatItIsGoneAndThatItIsBack) {
  ArmChoice choice;
  choice.text = "openhaptics";
  auto arm = open_arm(choice);
  ASSERT_TRUE(arm) << arm.error().message;
  std::vector<std::string> lines;
  const auto hears = [&](const std::string& words) {
    return comes_true([&] {
      const auto news = (*arm)->look();
      if (news && *news) lines.push_back(**news);
      return !lines.empty() && lines.back().find(words) != std::string::npos;
    });
  };
  EXPECT_TRUE(hears("Simulated PHANToM (serial 0042, 8.5 N)"));
  with([](HdStubDevice& d) { d.plugged = false; });
  EXPECT_TRUE(hears("the connection to it broke"));
  EXPECT_TRUE(comes_true([&] { return !with([](HdStubDevice& d) { return d.open; }); }));
  with([](HdStubDevice& d) { d.plugged = true; });
  EXPECT_TRUE(hears("works again"));
  EXPECT_EQ(lines.size(), 3u);
  EXPECT_EQ((*arm)->figures()["times_lost"], 1);
}

// The haptic loop holds a force; the plug is pulled between two of its ticks.
TEST_F(RealArm, UnpluggedDuringPlayItsForceCommandsFadeAndComeBackRampedWhenItReturns) {
  auto arm = openhaptics::OpenHapticsArm::open(patient());
  ASSERT_TRUE(arm) << arm.error().message;
  ASSERT_TRUE(comes_true([&] { return reads(**arm); }));
  TripleBuffer<HapticInput> input;
  TripleBuffer<TipState> output;
  HapticSettings settings;
  HapticLoop loop(**arm, ArmCalibration{}, {}, settings, input, output);
  Instant<PhysicsClock> now;
  const auto tick = [&] {
    HapticInput wish;
    wish.sustained = {1.0, 0.0, 0.0};
    now += settings.period;
    wish.time = now;
    input.write(wish);
    loop.tick(now);
  };
  const auto given = [&] { return force().x(); };
  EXPECT_TRUE(comes_true([&] {
    tick();
    return given() > 0.9;
  }));
  with([](HdStubDevice& d) { d.plugged = false; });
  EXPECT_TRUE(comes_true([&] {
    tick();
    return loop.fault() == ForceFault::bad_reading;
  }));
  EXPECT_EQ(force().norm(), 0.0);  // the device itself has nothing any more
  const int fade_ticks = static_cast<int>(settings.limits.fade_s / to_seconds(settings.period));
  for (int i = 0; i <= fade_ticks; ++i) tick();
  EXPECT_EQ(loop.records().back().commanded.norm(), 0.0);
  EXPECT_NE((*arm)->status().message.find("HD_"), std::string::npos);
  with([](HdStubDevice& d) { d.plugged = true; });
  EXPECT_TRUE(comes_true([&] {
    tick();
    return given() > 0.9;
  }));
  EXPECT_EQ(static_cast<int>(loop.fault()), static_cast<int>(ForceFault::none));
  const auto records = loop.records();
  const double largest_step = settings.limits.slew_n_s * to_seconds(settings.period);
  for (std::size_t i = 1; i < records.size(); ++i)
    EXPECT_LE((records[i].commanded - records[i - 1].commanded).norm(), largest_step);
}

}  // namespace
}  // namespace palpate
