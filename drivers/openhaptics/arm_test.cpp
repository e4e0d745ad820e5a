#include "drivers/openhaptics/arm.h"

#include <gtest/gtest.h>

#include <numbers>
#include <thread>

#include "drivers/openhaptics/stub_for_tests.h"
#include "tests/allocation_count.h"

namespace palpate::drivers::openhaptics {
namespace {

using OpenHaptics = StubTest;

bool is(const OpenHapticsArm& arm, device::HealthCode code) {
  const auto health = arm.status().health;
  return health && health->code == code;
}
std::string words_of(const OpenHapticsArm& arm) {
  return arm.status().health.value_or(device::HealthReport{}).words;
}

void turn(HdStubDevice& device, const Vector3& joints) {
  for (int i = 0; i < 3; ++i) device.turned[i] = joints[i];
}

// The newest sample of a cycle that began after this call.
device::ArmSample next_sample(OpenHapticsArm& arm) {
  const auto before = arm.status().cycles;
  EXPECT_TRUE(comes_true([&] { return arm.status().cycles >= before + 2; }));
  return arm.read();
}

TEST_F(OpenHaptics, ArmTellsWhoItIs) {
  const auto arm = opened(patient());
  EXPECT_EQ(arm->facts().model, "Simulated PHANToM");
  EXPECT_EQ(arm->facts().serial, "0042");
  EXPECT_EQ(arm->facts().library_version, "3.4.0");
  EXPECT_EQ(arm->facts().peak_n, 8.5);
  EXPECT_EQ(arm->facts().continuous_n, 1.4);
  EXPECT_EQ(words_of(*arm), "");
}

TEST_F(OpenHaptics, JointAnglesAreThoseOfTheArmWhicheverWayItsTurretCounts) {
  for (const bool left : {false, true}) {
    function<void()>("hd_stub_reset")();
    with([&](HdStubDevice& d) { d.turret_left = left; });
    const auto arm = opened(patient());
    for (const Vector3& turned :
         {Vector3(0.0, 0.3, 0.2), Vector3(0.01, 0.3, 0.2), Vector3(-0.01, 0.3, 0.2), Vector3(0.5, 0.1, -0.3),
          Vector3(-0.6, 0.9, 0.5), Vector3(0.02, 0.5, 0.1)}) {
      with([&](HdStubDevice& d) { turn(d, turned); });
      const device::ArmSample sample = next_sample(*arm);
      EXPECT_LT((sample.joints - turned).norm(), 1e-12) << sample.joints.transpose();
      // The place the device itself tells, from its own kinematics.
      const Vector3 tip = device::phantom_tip(sample.joints).m;
      EXPECT_GT(tip.x() * turned[0], turned[0] == 0.0 ? -1.0 : 0.0);
    }
    EXPECT_FALSE(arm->status().health);
  }
}

TEST_F(OpenHaptics, GimbalAnglesTurnTheStylusAsTheDeviceSeesIt) {
  with([&](HdStubDevice& d) {
    turn(d, {0.2, 0.4, 0.3});
    d.gimbal[0] = 0.5, d.gimbal[1] = 0.3, d.gimbal[2] = -0.4;  // right, up, counter-clockwise
  });
  const auto arm = opened(patient());
  // In the model the stylus turns about y, then x, then z, so up and clockwise count backwards.
  EXPECT_LT((next_sample(*arm).gimbal - Vector3(0.5, -0.3, 0.4)).norm(), 1e-12);
}

TEST_F(OpenHaptics, SamplesAreStampedInTheMachinesClockAndInOrder) {
  const auto arm = opened(patient());
  auto before = next_sample(*arm).stamp;
  for (int i = 0; i < 20; ++i) {
    const auto stamp = next_sample(*arm).stamp;
    EXPECT_GT(stamp, before);
    before = stamp;
  }
}

// Virtual work: the device's torques are those of this force on our model of the arm.
TEST_F(OpenHaptics, TheStylusButtonsComeWithTheSample) {
  const auto arm = opened(patient());
  EXPECT_TRUE(comes_true([&] { return reads(*arm); }));
  EXPECT_EQ(arm->read().buttons, 0u);
  with([](HdStubDevice& d) { d.buttons = 2; });
  EXPECT_TRUE(comes_true([&] { return arm->read().buttons == 2u; }));
}

TEST_F(OpenHaptics, ForceArrivesInArmBaseAxes) {
  for (const bool left : {false, true}) {
    function<void()>("hd_stub_reset")();
    const Vector3 turned(0.4, 0.6, 0.2);
    with([&](HdStubDevice& d) {
      turn(d, turned);
      d.turret_left = left;
    });
    const auto arm = opened(patient());
    for (const Vector3& wanted : {Vector3(1.0, 0.0, 0.0), Vector3(0.0, 2.0, 0.0), Vector3(0.3, -0.5, 1.5)}) {
      EXPECT_TRUE(comes_true([&] {
        arm->command(wanted);
        return (force() - wanted).norm() < 1e-12;
      }));
      const Vector3 torque = with([](HdStubDevice& d) { return Vector3(d.torque); });
      // Central differences of 1e-5 rad: 1e-10 of the arm's length, times the force.
      EXPECT_LT((torque - device::phantom_jacobian(turned).transpose() * wanted).norm(), 1e-8);
    }
  }
}

TEST_F(OpenHaptics, ForceIsCutToTheDevicesOwnPeakAndNonsenseIsNone) {
  with([](HdStubDevice& d) { d.nominal_force = d.true_force = 3.3; });
  const auto arm = opened(patient());
  arm->command({0.0, 50.0, 0.0});
  EXPECT_TRUE(comes_true([&] { return force().norm() > 3.299; }));
  EXPECT_LT((force() - Vector3(0.0, 3.3, 0.0)).norm(), 1e-9);
  arm->command({0.0, std::nan(""), 0.0});
  EXPECT_TRUE(comes_true([&] { return force().norm() == 0.0; }));
  arm->command({std::numeric_limits<double>::infinity(), 0.0, 0.0});
  EXPECT_EQ(arm->status().refused_commands, 2u);
  EXPECT_EQ(arm->status().force_errors, 0u);
  EXPECT_LE(with([](HdStubDevice& d) { return d.largest_force; }), 3.3 * (1.0 + 1e-12));
}

TEST_F(OpenHaptics, ForceThatNobodyRenewsFades) {
  auto settings = patient();
  settings.loop.watchdog_s = 0.3;
  const auto arm = opened(settings);
  arm->command({1.0, 0.0, 0.0});
  EXPECT_TRUE(comes_true([&] { return force().norm() > 0.9; }));
  EXPECT_TRUE(comes_true([&] { return force().norm() == 0.0; }));
  EXPECT_GT(arm->status().stale_cycles, 0u);
  EXPECT_TRUE(comes_true([&] {
    arm->command({1.0, 0.0, 0.0});
    return force().norm() > 0.9;
  }));
}

TEST_F(OpenHaptics, LetsGoWhenAnotherThreadSaysSoUntilTheNextCommand) {
  const auto arm = opened(patient());  // which holds a command for ten seconds
  arm->command({1.0, 0.0, 0.0});
  EXPECT_TRUE(comes_true([&] { return force().norm() > 0.9; }));
  std::thread([&] { arm->let_go(); }).join();
  EXPECT_TRUE(comes_true([&] { return force().norm() == 0.0; }));
  EXPECT_TRUE(comes_true([&] {
    arm->command({1.0, 0.0, 0.0});
    return force().norm() > 0.9;
  }));
}

TEST_F(OpenHaptics, EachForceErrorTurnsForcesOffForAMomentAndIsNamed) {
  auto settings = patient();
  const auto arm = opened(settings);
  for (const auto& [code, name] :
       std::initializer_list<std::pair<unsigned, const char*>>{{0x0200, "HD_WARM_MOTORS"},
                                                               {0x0201, "HD_EXCEEDED_MAX_FORCE"},
                                                               {0x0202, "HD_EXCEEDED_MAX_FORCE_IMPULSE"},
                                                               {0x0203, "HD_EXCEEDED_MAX_VELOCITY"},
                                                               {0x0204, "HD_FORCE_ERROR"},
                                                               {0x0402, "HD_FRAME_ERROR"}}) {
    SCOPED_TRACE(name);
    EXPECT_TRUE(comes_true([&] {
      arm->command({1.0, 0.0, 0.0});
      return force().norm() > 0.9;
    }));
    with([&, error = code](HdStubDevice& d) {
      d.error = error;
      d.error_cycles = 1000000;
    });
    EXPECT_TRUE(comes_true([&] { return is(*arm, device::HealthCode::arm_forces_off); }));
    const std::string line = words_of(*arm);
    EXPECT_TRUE(says(line, {"arm openhaptics", "the default device", name}));
    EXPECT_GT(line.size(), line.rfind("; ") + 10) << "a remedy: " << line;
    EXPECT_EQ(force().norm(), 0.0);
    EXPECT_TRUE(reads(*arm));  // the tip stays known
    with([](HdStubDevice& d) { d.error_cycles = 0; });
    EXPECT_TRUE(comes_true([&] { return !arm->status().health; }));
  }
  EXPECT_GE(arm->status().force_errors, 6u);
  EXPECT_EQ(arm->status().times_lost, 0u);
}

// The device grants less than it states, as one whose motors are weak: one cycle, and then none for hold_s,
// in which a ramp from zero would have reached that force again many times.
TEST_F(OpenHaptics, AForceTheDeviceRefusesIsNotRepeatedAtOnce) {
  with([](HdStubDevice& d) { d.true_force = 2.0; });
  auto settings = patient();
  settings.hold_s = 1000.0;
  const auto arm = opened(settings);
  arm->command({5.0, 0.0, 0.0});
  EXPECT_TRUE(comes_true([&] { return is(*arm, device::HealthCode::arm_forces_off); }));
  const auto before = arm->status().cycles;
  EXPECT_TRUE(comes_true([&] { return arm->status().cycles >= before + 100; }));
  EXPECT_EQ(arm->status().force_errors, 1u);
  EXPECT_EQ(force().norm(), 0.0);
  EXPECT_TRUE(says(words_of(*arm), {"HD_EXCEEDED_MAX_FORCE", "peak of the force limits"}));
}

TEST_F(OpenHaptics, UnpluggedArmIsNoticedNamedGivenBackAndOpenedAgain) {
  const auto arm = opened(patient());
  ASSERT_TRUE(comes_true([&] { return reads(*arm); }));
  EXPECT_TRUE(arm->read().connected);
  with([](HdStubDevice& d) { d.plugged = false; });
  EXPECT_TRUE(comes_true([&] { return !reads(*arm); }));
  EXPECT_FALSE(arm->read().connected);
  EXPECT_TRUE(is(*arm, device::HealthCode::arm_lost));
  EXPECT_TRUE(says(words_of(*arm), {"HD_COMM_ERROR", "connection to it broke", "cable"}));
  EXPECT_TRUE(comes_true([&] { return !with([](HdStubDevice& d) { return d.open; }); }));
  EXPECT_TRUE(comes_true([&] { return words_of(*arm).find("HD_DEVICE_FAULT") != std::string::npos; }));
  EXPECT_EQ(arm->status().times_lost, 1u);
  with([](HdStubDevice& d) {
    d.plugged = true;
    d.largest_force = 0.0;
  });
  EXPECT_TRUE(comes_true([&] { return reads(*arm); }));
  EXPECT_TRUE(arm->read().connected);
  EXPECT_EQ(words_of(*arm), "");
  EXPECT_EQ(with([](HdStubDevice& d) { return d.times_opened; }), 2);
  EXPECT_EQ(arm->status().times_lost, 1u);
}

TEST_F(OpenHaptics, AnotherArmInItsPlaceIsNotTakenForIt) {
  const auto arm = opened(patient());
  ASSERT_TRUE(comes_true([&] { return reads(*arm); }));
  with([](HdStubDevice& d) { d.plugged = false; });
  ASSERT_TRUE(comes_true([&] { return !reads(*arm); }));
  with([](HdStubDevice& d) { d.plugged = true, d.serial = "0043"; });
  EXPECT_TRUE(comes_true([&] { return words_of(*arm).find("0043") != std::string::npos; }));
  EXPECT_TRUE(says(words_of(*arm), {"Simulated PHANToM 0043", "was Simulated PHANToM 0042"}));
  EXPECT_FALSE(reads(*arm));
  EXPECT_FALSE(arm->read().connected);
  EXPECT_FALSE(with([](HdStubDevice& d) { return d.open; }));
  with([](HdStubDevice& d) { d.serial = "0042"; });
  EXPECT_TRUE(comes_true([&] { return reads(*arm); }));
}

TEST_F(OpenHaptics, EachDeviceErrorOfACycleEndsItAndIsNamed) {
  for (const auto& [code, name] :
       std::initializer_list<std::pair<unsigned, const char*>>{{0x0300, "HD_DEVICE_FAULT"},
                                                               {0x0302, "HD_COMM_ERROR"},
                                                               {0x0303, "HD_COMM_CONFIG_ERROR"},
                                                               {0x0304, "HD_TIMER_ERROR"},
                                                               {0x0104, "HD_BAD_HANDLE"},
                                                               {0x0600, "HD_INVALID_LICENSE"},
                                                               {0x7777, "unknown 0x7777"}}) {
    SCOPED_TRACE(name);
    function<void()>("hd_stub_reset")();
    const auto arm = opened(patient());
    ASSERT_TRUE(comes_true([&] { return reads(*arm); }));
    with([&, error = code](HdStubDevice& d) {
      d.init_error = error;  // and it does not come back
      d.error = error;
      d.error_cycles = 1;
    });
    EXPECT_TRUE(comes_true([&] { return is(*arm, device::HealthCode::arm_lost); }));
    EXPECT_FALSE(reads(*arm));
    EXPECT_TRUE(says(words_of(*arm), {name, "; "}));
    EXPECT_EQ(force().norm(), 0.0);
  }
}

TEST_F(OpenHaptics, ALibraryThatStopsCallingIsNoticed) {
  auto settings = patient();
  settings.loop.watchdog_s = 0.3;
  const auto arm = opened(settings);
  ASSERT_TRUE(comes_true([&] { return reads(*arm); }));
  freeze(true);
  EXPECT_TRUE(comes_true([&] { return !reads(*arm); }));
  EXPECT_TRUE(comes_true([&] { return is(*arm, device::HealthCode::arm_lost); }));
  EXPECT_TRUE(says(words_of(*arm), {"has not run its cycle for", "cable"}));
  freeze(false);
  EXPECT_TRUE(comes_true([&] { return reads(*arm); }));
}

TEST_F(OpenHaptics, ALibraryThatDoesNotComeBackFromTheDeviceHoldsNobodyUp) {
  auto settings = patient();
  settings.loop.watchdog_s = 0.3;
  const auto arm = opened(settings);
  ASSERT_TRUE(comes_true([&] { return reads(*arm); }));
  with([](HdStubDevice& d) { d.blocked = true; });
  EXPECT_TRUE(comes_true([&] { return with([](HdStubDevice& d) { return d.inside_begin; }); }));
  EXPECT_TRUE(comes_true([&] { return !reads(*arm); }));
  EXPECT_TRUE(comes_true([&] { return is(*arm, device::HealthCode::arm_lost); }));
  arm->command({1.0, 0.0, 0.0});  // returns
  with([](HdStubDevice& d) { d.blocked = false; });
  EXPECT_TRUE(comes_true([&] { return reads(*arm); }));
  EXPECT_EQ(with([](HdStubDevice& d) { return d.times_opened; }), 2);
}

TEST_F(OpenHaptics, InkwellIsAskedForAndThenCalibratesWithoutForce) {
  with([](HdStubDevice& d) { d.calibration = 0x5002; });
  const auto arm = opened(patient());
  EXPECT_FALSE(reads(*arm));
  EXPECT_TRUE(is(*arm, device::HealthCode::arm_uncalibrated));
  EXPECT_TRUE(says(words_of(*arm), {"calibrated", "stylus into the inkwell"}));
  arm->command({1.0, 0.0, 0.0});
  next_sample(*arm);
  EXPECT_EQ(force().norm(), 0.0);
  with([](HdStubDevice& d) { d.calibration = 0x5001; });
  EXPECT_TRUE(comes_true([&] { return reads(*arm); }));
  EXPECT_EQ(with([](HdStubDevice& d) { return d.times_calibrated; }), 1);
  // Later, in the middle of a force: it is taken away first.
  EXPECT_TRUE(comes_true([&] {
    arm->command({1.0, 0.0, 0.0});
    return force().norm() > 0.9;
  }));
  with([](HdStubDevice& d) { d.calibration = 0x5001; });
  EXPECT_TRUE(comes_true([&] { return with([](HdStubDevice& d) { return d.times_calibrated; }) == 2; }));
  EXPECT_FALSE(with([](HdStubDevice& d) { return d.calibrated_under_force; }));
}

TEST_F(OpenHaptics, EncodersAreSetOnlyWhenAPersonSaysThatTheArmIsAtReset) {
  with([](HdStubDevice& d) {
    d.calibration_style = 1;
    d.calibration = 0x5002;
  });
  auto settings = patient();
  {
    const auto arm = opened(settings);
    next_sample(*arm);
    EXPECT_FALSE(reads(*arm));
    EXPECT_TRUE(says(words_of(*arm), {"lost their zero", "reset position", "--arm-at-reset"}));
    EXPECT_EQ(with([](HdStubDevice& d) { return d.times_calibrated; }), 0);
  }
  settings.at_reset_position = true;
  const auto arm = opened(settings);
  EXPECT_TRUE(comes_true([&] { return reads(*arm); }));
  EXPECT_EQ(with([](HdStubDevice& d) { return d.times_calibrated; }), 1);
  // Unplugged and back without its zero: what the person said holds no more.
  with([](HdStubDevice& d) {
    d.plugged = false;
    d.calibration = 0x5002;
  });
  EXPECT_TRUE(comes_true([&] { return !reads(*arm); }));
  with([](HdStubDevice& d) { d.plugged = true; });
  EXPECT_TRUE(comes_true([&] { return is(*arm, device::HealthCode::arm_uncalibrated); }));
  EXPECT_FALSE(reads(*arm));
  EXPECT_EQ(with([](HdStubDevice& d) { return d.times_calibrated; }), 1);
}

TEST_F(OpenHaptics, JointsThatDoNotFitTheTipsPlaceTurnForcesOff) {
  const auto arm = opened(patient());
  EXPECT_TRUE(comes_true([&] {
    arm->command({1.0, 0.0, 0.0});
    return force().norm() > 0.9;
  }));
  with([](HdStubDevice& d) {
    d.slipped = true;
    d.turned[1] = 0.5;
  });
  EXPECT_TRUE(comes_true([&] { return force().norm() == 0.0; }));
  EXPECT_TRUE(is(*arm, device::HealthCode::arm_inconsistent));
  EXPECT_TRUE(says(words_of(*arm), {"differ by more than 25 mm", "nominal_arm"}));
}

TEST_F(OpenHaptics, AnotherOriginAndShortLinksAreNoInconsistency) {
  with([](HdStubDevice& d) {
    d.link_1_mm = d.link_2_mm = 133.35;
    d.origin_mm[1] = -65.5;
    d.origin_mm[2] = 88.0;
  });
  auto settings = patient();
  settings.lengths = {0.13335, 0.13335};
  const auto arm = opened(settings);
  for (const Vector3& turned : {Vector3(-0.5, 0.0, -0.4), Vector3(0.7, 1.0, 0.8)}) {
    with([&](HdStubDevice& d) { turn(d, turned); });
    EXPECT_LT((next_sample(*arm).joints - turned).norm(), 1e-12);
  }
  EXPECT_EQ(words_of(*arm), "");
}

TEST_F(OpenHaptics, ReadingsThatAreNotNumbersAreNoSample) {
  const auto arm = opened(patient());
  ASSERT_TRUE(comes_true([&] { return reads(*arm); }));
  const auto stamp = arm->read().stamp;
  EXPECT_TRUE(comes_true([&] { return arm->read().stamp > stamp; }));
  with([](HdStubDevice& d) { d.joints_broken = true; });
  next_sample(*arm);
  const auto last = arm->read().stamp;
  next_sample(*arm);
  EXPECT_EQ(arm->read().stamp, last);  // and so goes stale
  const Duration waited = arm->read().waited;
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_GE(arm->read().waited, waited + std::chrono::milliseconds(5)) << "and says so";
  arm->command({1.0, 0.0, 0.0});
  next_sample(*arm);
  EXPECT_EQ(force().norm(), 0.0);
}

TEST_F(OpenHaptics, DevicesAreChosenByNameAndWorkBesideEachOther) {
  auto left = patient(), right = patient();
  left.name = "Left";
  right.name = "Right";
  with([](HdStubDevice& d) { turn(d, {0.3, 0.1, 0.1}); }, 1);
  with([](HdStubDevice& d) { turn(d, {-0.3, 0.2, 0.2}); }, 2);
  const auto first = opened(left);
  const auto second = opened(right);
  EXPECT_LT((next_sample(*first).joints - Vector3(0.3, 0.1, 0.1)).norm(), 1e-12);
  EXPECT_LT((next_sample(*second).joints - Vector3(-0.3, 0.2, 0.2)).norm(), 1e-12);
  EXPECT_TRUE(comes_true([&] {
    first->command({1.0, 0.0, 0.0});
    second->command({0.0, 1.0, 0.0});
    return force(1).x() == 1.0 && force(2).y() == 1.0;
  }));
  EXPECT_EQ(force(1).y(), 0.0);
  EXPECT_EQ(force(2).x(), 0.0);
  with([](HdStubDevice& d) { d.plugged = false; }, 1);
  EXPECT_TRUE(comes_true([&] { return !reads(*first); }));
  EXPECT_TRUE(says(words_of(*first), {"device 'Left'"}));
  EXPECT_TRUE(comes_true([&] { return reads(*second); }));
  EXPECT_EQ(second->status().times_lost, 0u);
}

TEST_F(OpenHaptics, ClosingTakesTheForceAwayAndGivesTheDeviceBack) {
  auto arm = opened(patient());
  EXPECT_TRUE(comes_true([&] {
    arm->command({1.0, 0.0, 0.0});
    return force().norm() > 0.9;
  }));
  EXPECT_TRUE(scheduler_runs());
  arm.reset();
  EXPECT_EQ(force().norm(), 0.0);
  EXPECT_FALSE(with([](HdStubDevice& d) { return d.open; }));
  EXPECT_FALSE(scheduler_runs());
  EXPECT_TRUE(OpenHapticsArm::open(patient()));
}

TEST_F(OpenHaptics, NeitherTheHapticLoopsCallsNorACycleAllocate) {
  const auto arm = opened(patient());
  ASSERT_TRUE(comes_true([&] { return reads(*arm); }));
  const auto cycles = [&] { return with([](HdStubDevice& d) { return d.cycles; }); };
  const auto begun = cycles();
  const std::size_t before = allocations();
  for (int i = 0; i < 1000; ++i) arm->command(arm->read().joints);
  const bool went_on = comes_true([&] { return cycles() >= begun + 100; });
  EXPECT_EQ(allocations(), before);
  EXPECT_TRUE(went_on);
}

}  // namespace
}  // namespace palpate::drivers::openhaptics
