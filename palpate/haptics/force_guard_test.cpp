#include "palpate/haptics/force_guard.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

namespace palpate::haptics {
namespace {

constexpr double kMillisecond = 0.001;
const SafetyInputs kGood{.elapsed_s = kMillisecond};

ForceGuard running_guard() {
  ForceLimits limits;
  limits.start_ramp_s = 0.0;
  ForceGuard guard(limits, true);
  guard.tick(kGood);
  EXPECT_EQ(guard.state(), ForceState::running);
  EXPECT_EQ(guard.gain(), 1.0);
  return guard;
}

TEST(ForceGuard, WhereSomebodyHasToArmForcesTheyAreOffUntilThenAndBeginWithTheRamp) {
  ForceGuard guard({}, true, false);
  for (int tick = 0; tick < 5000; ++tick) {
    guard.tick(kGood);
    ASSERT_EQ(guard.state(), ForceState::safe);
    ASSERT_EQ(guard.fault(), ForceFault::not_armed);
    ASSERT_EQ(guard.gain(), 0.0);
  }
  ASSERT_TRUE(guard.rearm());
  guard.tick(kGood);
  EXPECT_EQ(guard.state(), ForceState::running);
  EXPECT_LT(guard.gain(), 0.01);
  ForceGuard unchecked({}, false, false);
  EXPECT_EQ(unchecked.fault(), ForceFault::arm_unchecked);
  EXPECT_FALSE(unchecked.rearm());
}

struct Sign {
  ForceFault fault;
  std::function<void(SafetyInputs&)> spoil;
};

const std::vector<Sign> kHealing{
    {ForceFault::stale_input, [](SafetyInputs& s) { s.input_age_s = 0.005; }},
    {ForceFault::stale_input, [](SafetyInputs& s) { s.input_age_s = std::nan(""); }},
    {ForceFault::bad_force, [](SafetyInputs& s) { s.requested_good = false; }},
    {ForceFault::bad_reading, [](SafetyInputs& s) { s.reading_good = false; }},
    {ForceFault::arm_silent, [](SafetyInputs& s) { s.reading_age_s = 0.005; }},
    {ForceFault::outside_workspace, [](SafetyInputs& s) { s.inside_workspace = false; }}};
const std::vector<Sign> kLasting{{ForceFault::overspeed, [](SafetyInputs& s) { s.tip_speed = 3.01; }},
                                 {ForceFault::overspeed, [](SafetyInputs& s) { s.tip_speed = std::nan(""); }},
                                 {ForceFault::arm_lost, [](SafetyInputs& s) { s.connected = false; }},
                                 {ForceFault::clamp_tripped, [](SafetyInputs& s) { s.clamp_good = false; }}};

TEST(ForceGuard, NothingIsWrongBeforeEverythingHasBeenHeardOf) {
  ForceGuard guard(ForceLimits{}, true);
  SafetyInputs silence = kGood;
  silence.input_age_s = silence.reading_age_s = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 100; ++i) guard.tick(silence);
  EXPECT_EQ(guard.state(), ForceState::ready);
  EXPECT_EQ(guard.fault(), ForceFault::none);
  EXPECT_EQ(guard.gain(), 0.0);
  guard.tick(kGood);
  EXPECT_EQ(guard.state(), ForceState::running);
  EXPECT_EQ(guard.gain(), 0.0);  // the ramp of 1 s begins with nothing
  guard.tick(kGood);
  EXPECT_NEAR(guard.gain(), 0.001, 1e-15);
}

TEST(ForceGuard, EveryHealingFaultFadesTheForceAndComesBackAlongTheRamp) {
  for (const auto& sign : kHealing) {
    ForceGuard guard = running_guard();
    SafetyInputs inputs = kGood;
    sign.spoil(inputs);
    guard.tick(inputs);
    EXPECT_EQ(guard.state(), ForceState::degraded) << name_of(sign.fault);
    EXPECT_EQ(guard.fault(), sign.fault);
    EXPECT_LT(guard.gain(), 1.0);
    for (int i = 0; i < 14; ++i) guard.tick(inputs);
    EXPECT_EQ(guard.gain(), 0.0) << "15 ms after " << name_of(sign.fault);
    guard.tick(kGood);
    EXPECT_EQ(guard.state(), ForceState::running);
    EXPECT_FALSE(guard.rearm());  // there is nothing to re-arm
  }
}

TEST(ForceGuard, ALateTickIsToldAndGoesOnFromWhatTheDeviceHolds) {
  for (const double held : {1.0, 0.3, 0.0}) {
    ForceGuard guard = running_guard();
    guard.tick({.elapsed_s = 0.012, .held = held});
    EXPECT_EQ(guard.fault(), ForceFault::late_tick);
    EXPECT_EQ(guard.state(), ForceState::degraded);
    EXPECT_DOUBLE_EQ(guard.gain(), held);
    guard.tick(kGood);
    EXPECT_EQ(guard.state(), ForceState::running);
    EXPECT_DOUBLE_EQ(guard.gain(), std::min(1.0, held + 0.001 / 0.040));
  }
}

TEST(ForceGuard, EveryLastingFaultKeepsForcesOffUntilRearmed) {
  for (const auto& sign : kLasting) {
    ForceGuard guard = running_guard();
    SafetyInputs inputs = kGood;
    sign.spoil(inputs);
    guard.tick(inputs);
    EXPECT_EQ(guard.state(), ForceState::safe) << name_of(sign.fault);
    EXPECT_EQ(guard.fault(), sign.fault);
    EXPECT_FALSE(heals(sign.fault));
    EXPECT_FALSE(guard.rearm()) << "the reason is still there";
    for (int i = 0; i < 1000; ++i) guard.tick(kGood);
    EXPECT_EQ(guard.state(), ForceState::safe);
    EXPECT_EQ(guard.gain(), 0.0);
    EXPECT_TRUE(guard.rearm());
    EXPECT_EQ(guard.state(), ForceState::ready);
    guard.tick(kGood);
    EXPECT_EQ(guard.state(), ForceState::running);
  }
}

TEST(ForceGuard, AnOverspeedHidesNoOtherLastingFaultThatFollowsIt) {
  for (const auto& sign : kLasting) {
    if (sign.fault == ForceFault::overspeed) continue;
    ForceGuard guard = running_guard();
    SafetyInputs fast = kGood;
    fast.tip_speed = 10.0;
    guard.tick(fast);
    ASSERT_EQ(guard.fault(), ForceFault::overspeed);
    SafetyInputs inputs = kGood;
    sign.spoil(inputs);
    guard.tick(inputs);
    guard.tick(kGood);
    EXPECT_EQ(guard.state(), ForceState::safe);
    EXPECT_EQ(guard.fault(), sign.fault) << "whoever re-arms after an overspeed must not re-arm this";
  }
}

TEST(ForceGuard, ALastingFaultCountsBeforeTheFirstForceToo) {
  ForceGuard guard(ForceLimits{}, true);
  SafetyInputs inputs = kGood;
  inputs.connected = false;
  inputs.input_age_s = 1.0;
  guard.tick(inputs);
  EXPECT_EQ(guard.state(), ForceState::safe);
}

TEST(ForceGuard, WarmMotorsAreDegradedWithoutAFault) {
  ForceGuard guard = running_guard();
  SafetyInputs inputs = kGood;
  inputs.warm = true;
  guard.tick(inputs);
  EXPECT_EQ(guard.state(), ForceState::degraded);
  EXPECT_EQ(guard.fault(), ForceFault::none);
  EXPECT_EQ(guard.gain(), 1.0);
}

TEST(ForceGuard, AnUnknownArmGetsTheWeakestLimits) {
  const ForceLimits premium = force_limits_of("phantom-premium-1.5"),
                    unknown = force_limits_of("no such arm");
  EXPECT_EQ(premium.peak_n, 8.5);
  EXPECT_EQ(premium.max_tip_speed_m_s, 3.0);
  EXPECT_EQ(unknown.peak_n, 3.3);
  EXPECT_EQ(unknown.max_tip_speed_m_s, 1.2);
  EXPECT_NO_THROW(check_force_limits(premium));
  EXPECT_NO_THROW(check_force_limits(unknown));
}

TEST(ForceGuard, ImpossibleLimitsAreRefusedByName) {
  const auto refused = [](const char* name, auto&& spoil) {
    ForceLimits limits;
    spoil(limits);
    try {
      check_force_limits(limits);
      ADD_FAILURE() << name << " was accepted";
    } catch (const std::invalid_argument& reason) {
      EXPECT_NE(std::string(reason.what()).find(name), std::string::npos) << reason.what();
    }
  };
  refused("peak_n", [](ForceLimits& l) { l.peak_n = 0.0; });
  refused("continuous_n", [](ForceLimits& l) { l.continuous_n = -1.0; });
  refused("continuous_s", [](ForceLimits& l) { l.continuous_s = 0.01; });
  refused("slew_n_s", [](ForceLimits& l) { l.slew_n_s = std::nan(""); });
  refused("start_ramp_s", [](ForceLimits& l) { l.start_ramp_s = -0.1; });
  refused("fade_s", [](ForceLimits& l) { l.fade_s = std::numeric_limits<double>::infinity(); });
  refused("max_tip_speed_m_s", [](ForceLimits& l) { l.max_tip_speed_m_s = 0.0; });
  refused("stale_s", [](ForceLimits& l) { l.stale_s = 0.0; });
  refused("max_backlog_s", [](ForceLimits& l) { l.max_backlog_s = -1.0; });
  refused("most_damping_n_s_m", [](ForceLimits& l) { l.most_damping_n_s_m = -1.0; });
  refused("slew_n_s * fade_s", [](ForceLimits& l) { l.slew_n_s = 100.0; });
  refused("joint_range", [](ForceLimits& l) { l.joint_range[1] = {1.0, -1.0}; });
}

}  // namespace
}  // namespace palpate::haptics
