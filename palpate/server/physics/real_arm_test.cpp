#include <gtest/gtest.h>

#include <cstdlib>

#include "drivers/laboratory/driver.h"
#include "drivers/openhaptics/driver.h"
#include "drivers/openhaptics/stub_for_tests.h"
#include "palpate/device/health_monitor.h"
#include "palpate/haptics/haptic_loop.h"
#include "palpate/time/clock.h"

namespace palpate::server::physics {
namespace {

using drivers::openhaptics::comes_true;

class RealArm : public drivers::openhaptics::StubTest {
 protected:
  RealArm() { setenv("PALPATE_LIBHD", drivers::openhaptics::kStub, 1); }
  ~RealArm() override { unsetenv("PALPATE_LIBHD"); }
  static device::DriverRegistry drivers() {
    device::DriverRegistry registry;
    drivers::laboratory::add_to(registry);
    drivers::openhaptics::add_to(registry);
    return registry;
  }
  static Expected<std::unique_ptr<device::OpenedArm>> open_arm(const std::string& uri) {
    return drivers().open(device::ArmRequest{.uri = uri, .nominal = {}});
  }
};

TEST_F(RealArm, IsChosenByNameAndOtherChoicesAreWrongUse) {
  auto arm = open_arm("openhaptics:Right");
  ASSERT_TRUE(arm) << arm.error().message;
  EXPECT_TRUE(with([](HdStubDevice& d) { return d.open; }, 2));
  for (const char* text : {"", "openhaptics:", "openhaptic", "phantom", "openhapticsRight"}) {
    const auto refusal = open_arm(text);
    ASSERT_FALSE(refusal) << text;
    EXPECT_EQ(refusal.error().exit_code(), 2);
    EXPECT_EQ(refusal.error().message,
              std::string("is '") + text + "'; lab, openhaptics or openhaptics:NAME is expected");
  }
}

TEST_F(RealArm, LowersTheForceLimitsToItsOwnAndNeverRaisesThem) {
  with([](HdStubDevice& d) {
    d.nominal_force = 3.3;
    d.nominal_continuous = 0.9;
  });
  {
    const auto arm = open_arm("openhaptics");
    ASSERT_TRUE(arm);
    EXPECT_EQ(haptics::lowered_to({}, (*arm)->facts()).peak_n, 3.3);
    EXPECT_EQ(haptics::lowered_to({}, (*arm)->facts()).continuous_n, 0.9);
  }
  with([](HdStubDevice& d) {
    d.nominal_force = 37.5;
    d.nominal_continuous = 6.2;
  });
  const auto arm = open_arm("openhaptics");
  ASSERT_TRUE(arm);
  EXPECT_EQ(haptics::lowered_to({}, (*arm)->facts()).peak_n, haptics::ForceLimits().peak_n);
  EXPECT_EQ(haptics::lowered_to({}, (*arm)->facts()).continuous_n, haptics::ForceLimits().continuous_n);
}

TEST_F(RealArm, TellsOnceWhoItIsThatItIsGoneAndThatItIsBack) {
  auto arm = open_arm("openhaptics");
  ASSERT_TRUE(arm) << arm.error().message;
  const LogCapture told;
  device::HealthMonitor<PhysicsClock> monitor{Log("physics")};
  const auto hears = [&](const std::string& words) {
    return comes_true([&] {
      monitor.follow((*arm)->health(), {});
      return told.text().find(words) != std::string::npos;
    });
  };
  EXPECT_NE((*arm)->description().find("Simulated PHANToM (serial 0042, 8.5 N)"), std::string::npos);
  with([](HdStubDevice& d) { d.plugged = false; });
  EXPECT_TRUE(hears("the connection to it broke"));
  EXPECT_TRUE(comes_true([&] { return !with([](HdStubDevice& d) { return d.open; }); }));
  with([](HdStubDevice& d) { d.plugged = true; });
  EXPECT_TRUE(hears("works again"));
  EXPECT_EQ(told.lines().size(), 2u) << told.text();
  EXPECT_EQ((*arm)->figures()["times_lost"], 1);
}

// The stub's arm, as if its forces had been checked and weighed.
haptics::ForcePermit checked() {
  rig::Rig rig;
  rig.arm.emplace();
  rig.forces = rig::force_calibration_of(rig, "openhaptics Simulated PHANToM 0042");
  rig.forces->gain = 1.0;
  rig.forces->peak = 8.5;
  device::ArmFacts facts;
  facts.identity = rig.forces->identity;
  return haptics::ForcePermit::of(facts, rig);
}

// The haptic loop on a real arm, with a wish of its own in every tick.
struct Play {
  Play(drivers::openhaptics::OpenHapticsArm& arm, const haptics::HapticSettings& settings)
      : loop(arm, rig::ArmCalibration{}, {}, settings, input, output) {}
  void tick(Instant<PhysicsClock> now) {
    request.time = now;
    input.write(request);
    loop.tick(now);
  }
  TripleBuffer<haptics::HapticInput> input;
  TripleBuffer<scene::TipState> output;
  haptics::HapticInput request;
  haptics::HapticLoop loop;
};

// The haptic loop holds a force; the plug is pulled between two of its ticks.
TEST_F(RealArm, UnpluggedDuringPlayItsForcesFadeAndStayOffUntilItIsBackAndSomebodyRearms) {
  auto arm = drivers::openhaptics::OpenHapticsArm::open(patient());
  ASSERT_TRUE(arm) << arm.error().message;
  ASSERT_TRUE(comes_true([&] { return reads(**arm); }));
  const haptics::HapticSettings settings{.permit = checked()};
  Play play(**arm, settings);
  play.request.continuous = {1.0, 0.0, 0.0};
  Instant<PhysicsClock> now;
  const auto tick = [&] { play.tick(now += settings.period); };
  const auto given = [&] { return force().x(); };
  EXPECT_TRUE(comes_true([&] {
    tick();
    return given() > 0.9;
  }));
  with([](HdStubDevice& d) { d.plugged = false; });
  EXPECT_TRUE(comes_true([&] {
    tick();
    return play.loop.fault() == device::ForceFault::arm_lost;
  }));
  EXPECT_EQ(force().norm(), 0.0);  // the device itself has nothing any more
  const auto condition = play.loop.condition();
  EXPECT_EQ(device::condition_text({condition.state, condition.fault}), "safe: arm lost");
  EXPECT_EQ(condition.trip_fault, device::ForceFault::arm_lost);
  const int fade_ticks = static_cast<int>(settings.limits.fade_s / to_seconds(settings.period));
  for (int i = 0; i <= fade_ticks; ++i) tick();
  EXPECT_EQ(play.loop.records().back().commanded.norm(), 0.0);
  EXPECT_NE((*arm)->status().health.value_or(device::HealthReport{}).words.find("HD_"), std::string::npos);
  EXPECT_FALSE(play.loop.rearm()) << "still unplugged";
  with([](HdStubDevice& d) {
    d.plugged = true;
    d.largest_force = 0.0;
  });
  EXPECT_TRUE(comes_true([&] {
    tick();
    return reads(**arm);
  }));
  for (int i = 0; i < 1500; ++i) tick();
  EXPECT_EQ(play.loop.state(), device::ForceState::safe);
  EXPECT_EQ(with([](HdStubDevice& d) { return d.largest_force; }), 0.0);
  EXPECT_TRUE(play.loop.rearm());
  EXPECT_TRUE(comes_true([&] {
    tick();
    return given() > 0.9;
  }));
  EXPECT_EQ(play.loop.fault(), device::ForceFault::none);
  const auto records = play.loop.records();
  const double largest_step = settings.limits.slew_n_s * to_seconds(settings.period);
  for (std::size_t i = 1; i < records.size(); ++i)
    EXPECT_LE((records[i].commanded - records[i - 1].commanded).norm(), largest_step);
}

// A long, soft impact, to whose length a busy machine's pauses are short; no pause counts as a fault here.
double lost_share_of_an_impact(drivers::openhaptics::OpenHapticsArm& arm) {
  haptics::HapticSettings settings{.permit = checked()};
  settings.limits.start_ramp_s = 0.0;
  settings.limits.stale_s = 10.0;
  Play play(arm, settings);
  const MonotonicClock<PhysicsClock> clock;
  play.tick(clock.now());
  auto& impact = play.request.impact;
  impact.number = 1;
  impact.start = clock.now();
  impact.duration = seconds(0.5);
  impact.direction = Vector3::UnitX();
  impact.mass = 1.0;
  impact.approach_speed = 0.3;
  impact.restitution = 0.8;
  EXPECT_TRUE(comes_true([&] {
    play.tick(clock.now());
    return play.loop.statistics().impulse_requested > 0.0;
  }));
  EXPECT_NEAR(play.loop.statistics().impulse_requested, 0.54, 1e-12);
  return play.loop.statistics().lost_impulse_rel();
}

TEST_F(RealArm, WhatItRefusesOrCutsOfAnImpactCountsAsLostImpulse) {
  {
    auto arm = drivers::openhaptics::OpenHapticsArm::open(patient());
    ASSERT_TRUE(arm) << arm.error().message;
    ASSERT_TRUE(comes_true([&] { return reads(**arm); }));
    EXPECT_LT(lost_share_of_an_impact(**arm), 0.1);
  }
  {
    with([](HdStubDevice& d) { d.nominal_force = d.true_force = 0.1; });  // of more than 1 N asked
    auto arm = drivers::openhaptics::OpenHapticsArm::open(patient());
    ASSERT_TRUE(arm) << arm.error().message;
    ASSERT_TRUE(comes_true([&] { return reads(**arm); }));
    EXPECT_GT(lost_share_of_an_impact(**arm), 0.8);
  }
  with([](HdStubDevice& d) {
    d.nominal_force = d.true_force = 8.5;
    d.error = 0x0200;  // HD_WARM_MOTORS
    d.error_cycles = 1000000;
  });
  auto arm = drivers::openhaptics::OpenHapticsArm::open(patient());
  ASSERT_TRUE(arm) << arm.error().message;
  ASSERT_TRUE(comes_true([&] { return reads(**arm); }));
  EXPECT_GT(lost_share_of_an_impact(**arm), 0.9);
}

}  // namespace
}  // namespace palpate::server::physics
