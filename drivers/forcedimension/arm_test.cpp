// The driver against simulated devices behind the maker's binary interface. Nothing here measures time: waits are for what
// must come, however long a busy machine takes.
#include "drivers/forcedimension/arm.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "drivers/forcedimension/driver.h"
#include "drivers/forcedimension/stub_for_tests.h"

namespace palpate::drivers::forcedimension {
namespace {

using device::HealthCode;

class ForceDimensionArmTest : public StubTest {};

TEST_F(ForceDimensionArmTest, TellsWhoItIsItsPlaceAndItsButtons) {
  with([](DhdStubDevice& d) {
    d.place[0] = 0.01;
    d.place[1] = -0.02;
    d.place[2] = 0.03;
    d.buttons = 5;
  });
  const auto arm = opened(patient());
  EXPECT_EQ(arm->facts().model, "omega.3");
  EXPECT_EQ(arm->facts().serial, 1001);
  EXPECT_EQ(arm->facts().library_version, "3.17.5");
  EXPECT_EQ(arm->facts().peak_n, 12.0);
  EXPECT_TRUE(arm->facts().watchdog);
  const auto sample = arm->read();
  EXPECT_EQ(Vector3(sample.joints), Vector3(0.01, -0.02, 0.03));
  EXPECT_EQ(sample.gimbal, Vector3(Vector3::Zero())) << "it has no wrist";
  EXPECT_EQ(sample.buttons, 5u);
  EXPECT_TRUE(sample.connected);
  EXPECT_TRUE(is_well(*arm));
  EXPECT_TRUE(comes_true([&] { return arm->status().exchanges > 20; }));
}

TEST_F(ForceDimensionArmTest, AWristTellsItsTurnAndHasToKnowItsZero) {
  const Vector3 gimbal(0.3, -0.4, 0.7);
  const Matrix3 turn =
      (Eigen::AngleAxisd(gimbal[0], Vector3::UnitY()) * Eigen::AngleAxisd(gimbal[1], Vector3::UnitX()) *
       Eigen::AngleAxisd(gimbal[2], Vector3::UnitZ()))
          .toRotationMatrix();
  with(
      [&](DhdStubDevice& d) {
        d.plugged = true;
        for (int row = 0; row < 3; ++row)
          for (int column = 0; column < 3; ++column) d.rotation[row][column] = turn(row, column);
      },
      1);
  auto settings = patient();
  settings.serial = 1002;
  const auto arm = opened(settings);
  EXPECT_EQ(arm->facts().model, "sigma.7");
  EXPECT_TRUE(arm->facts().wrist);
  EXPECT_LT((arm->read().gimbal - gimbal).norm(), 1e-12);
  with([](DhdStubDevice& d) { d.wrist_initialised = false; }, 1);
  EXPECT_TRUE(comes_true([&] { return is(*arm, HealthCode::arm_uncalibrated, "wrist"); }));
}

TEST_F(ForceDimensionArmTest, PushesWhatIsCommandedAndNothingElse) {
  const auto arm = opened(patient());
  const Vector3 force(0.5, -1.0, 2.0);
  ASSERT_TRUE(gives(*arm, force));
  with([](DhdStubDevice& d) {
    for (const double other : d.other) EXPECT_EQ(other, 0.0);
  });
  EXPECT_TRUE(comes_true([&] {
    const auto held = arm->read().held;
    return held && (*held - force).norm() < 1e-12;
  }));
  EXPECT_EQ(arm->saturations(), 0u);
}

TEST_F(ForceDimensionArmTest, FadesWhereNobodyCommandsAndLetsGoWhenTold) {
  auto settings = patient();
  settings.loop.watchdog_s = 0.3;
  const auto arm = opened(settings);
  const Vector3 force(0.0, 0.0, 2.0);
  ASSERT_TRUE(gives(*arm, force));
  EXPECT_TRUE(comes_true([&] { return this->force() == Vector3::Zero(); })) << "no command any more";
  EXPECT_GT(arm->status().stale_exchanges, 0u);
  ASSERT_TRUE(gives(*arm, force));
  arm->let_go();
  EXPECT_TRUE(comes_true([&] { return this->force() == Vector3::Zero(); }));
  EXPECT_LE(with([](DhdStubDevice& d) { return d.largest_force; }), force.norm() + 1e-12);
}

TEST_F(ForceDimensionArmTest, TellsWhenItCannotGiveSoMuch) {
  with([](DhdStubDevice& d) { d.strength = 3.0; });
  const auto arm = opened(patient());
  const Vector3 force(0.0, 0.0, 5.0);
  ASSERT_TRUE(comes_true_while_pushing(*arm, force, [&] { return arm->saturations() > 0; }));
  EXPECT_TRUE(comes_true_while_pushing(*arm, force, [&] { return !arm->read().held; }))
      << "how much it gives is not known then";
  EXPECT_TRUE(is_well(*arm));
}

TEST_F(ForceDimensionArmTest, NothingAboveItsPeakIsCommanded) {
  with([](DhdStubDevice& d) { d.strength = 100.0; });
  {
    const auto arm = opened(patient());
    const Vector3 most(0.0, 0.0, arm->facts().peak_n);
    ASSERT_TRUE(comes_true_while_pushing(*arm, 3.0 * most, [&] { return (force() - most).norm() < 1e-9; }));
    EXPECT_TRUE(comes_true_while_pushing(*arm, 3.0 * most, [&] { return arm->read().withheld.z() > 0.0; }))
        << "what was held back is told";
  }
  with([](DhdStubDevice& d) { d.max_force = 4.0; });
  EXPECT_EQ(opened(patient())->facts().peak_n, 4.0) << "a lower one that the library states counts";
}

TEST_F(ForceDimensionArmTest, WhatIsNoForceIsNone) {
  const auto arm = opened(patient());
  const Vector3 nonsense(0.0, std::nan(""), 1.0);
  EXPECT_TRUE(comes_true_while_pushing(*arm, nonsense, [&] { return arm->status().refused_commands > 50; }));
  EXPECT_EQ(with([](DhdStubDevice& d) { return d.largest_force; }), 0.0);
}

TEST_F(ForceDimensionArmTest, WhoeverSwitchesItsForcesOffHasThemOff) {
  const auto arm = opened(patient());
  const Vector3 force(0.0, 0.0, 2.0);
  ASSERT_TRUE(gives(*arm, force));
  const auto off = [&](int cause) {
    with([&](DhdStubDevice& d) {
      d.forces_on = false;
      d.off_cause = cause;
    });
  };
  off(1);
  ASSERT_TRUE(comes_true([&] { return is(*arm, HealthCode::arm_forces_off, "force button"); }));
  EXPECT_EQ(arm->read().held, Vector3(Vector3::Zero()));
  const auto commands = with([](DhdStubDevice& d) { return d.commands; });
  ASSERT_TRUE(comes_true_while_pushing(
      *arm, force, [&] { return with([](DhdStubDevice& d) { return d.commands; }) > commands + 500; }));
  EXPECT_FALSE(with([](DhdStubDevice& d) { return d.forces_on; })) << "it is not switched on again";
  off(2);
  EXPECT_TRUE(comes_true([&] { return is(*arm, HealthCode::arm_forces_off, "too fast"); }));
  off(6);
  EXPECT_TRUE(comes_true([&] { return is(*arm, HealthCode::arm_forces_off, "nobody holds it"); }));
  with([](DhdStubDevice& d) {
    d.forces_on = true;
    d.off_cause = 0;
  });
  EXPECT_TRUE(comes_true([&] { return is_well(*arm); }));
  EXPECT_TRUE(gives(*arm, force));
}

TEST_F(ForceDimensionArmTest, TheDeviceLetsGoOfAnOldForceAndIsSwitchedOnAgain) {
  const auto arm = opened(patient());
  EXPECT_DOUBLE_EQ(with([](DhdStubDevice& d) { return d.watchdog_s; }), 0.020);
  const Vector3 force(0.0, 0.0, 2.0);
  ASSERT_TRUE(gives(*arm, force));
  with([](DhdStubDevice& d) { d.clock_s = 0.021; });
  ASSERT_TRUE(comes_true([&] { return is(*arm, HealthCode::arm_forces_off, "this program was late"); }));
  EXPECT_TRUE(gives(*arm, force)) << "its being late was ours, not a person's wish";
  EXPECT_TRUE(comes_true([&] { return is_well(*arm); }));
}

TEST_F(ForceDimensionArmTest, WithoutPowerOrZeroOrWithAnErrorItSaysSo) {
  const auto arm = opened(patient());
  with([](DhdStubDevice& d) { d.reset = true; });
  ASSERT_TRUE(comes_true([&] { return is(*arm, HealthCode::arm_uncalibrated, "rest place"); }));
  with([](DhdStubDevice& d) {
    d.reset = false;
    d.controller_error = true;
  });
  ASSERT_TRUE(comes_true([&] { return is(*arm, HealthCode::arm_forces_off, "reports an error"); }));
  EXPECT_TRUE(comes_true([&] { return arm->read().joints.allFinite(); }));
  with([](DhdStubDevice& d) {
    d.controller_error = false;
    d.powered = false;
  });
  ASSERT_TRUE(comes_true([&] { return is(*arm, HealthCode::arm_forces_off, "no power"); }));
}

TEST_F(ForceDimensionArmTest, WithoutAZeroThereIsNoPlaceAndNoForce) {
  with([](DhdStubDevice& d) { d.reset = true; });
  auto settings = patient();
  settings.loop.watchdog_s = 0.3;
  const auto arm = opened(settings);
  EXPECT_FALSE(arm->read().joints.allFinite());
  const auto begun = arm->status().exchanges;
  EXPECT_TRUE(
      comes_true_while_pushing(*arm, {0, 0, 3}, [&] { return arm->status().exchanges > begun + 50; }));
  EXPECT_EQ(with([](DhdStubDevice& d) { return d.largest_force; }), 0.0);
  with([](DhdStubDevice& d) { d.reset = false; });
  EXPECT_TRUE(comes_true([&] { return arm->read().joints.allFinite(); }));
}

TEST_F(ForceDimensionArmTest, ThatIsUnpluggedIsLostAndComesBackByItself) {
  const auto arm = opened(patient());
  ASSERT_TRUE(gives(*arm, {0, 0, 1}));
  with([](DhdStubDevice& d) { d.plugged = false; });
  ASSERT_TRUE(comes_true([&] { return is(*arm, HealthCode::arm_lost, ""); }));
  const auto sample = arm->read();
  EXPECT_FALSE(sample.connected);
  EXPECT_FALSE(sample.joints.allFinite());
  EXPECT_EQ(sample.held, Vector3(Vector3::Zero()));
  EXPECT_EQ(arm->status().health->words.find('\n'), std::string::npos);
  // Another one in its place is not it.
  with([](DhdStubDevice& d) {
    d.plugged = true;
    d.serial = 7;
  });
  ASSERT_TRUE(comes_true([&] { return is(*arm, HealthCode::arm_lost, "omega.3 7, and was omega.3 1001"); }));
  with([](DhdStubDevice& d) { d.serial = 1001; });
  ASSERT_TRUE(comes_true([&] { return is_well(*arm) && arm->read().joints.allFinite(); }));
  EXPECT_TRUE(arm->read().connected);
  EXPECT_EQ(arm->status().times_lost, 1u);
}

TEST_F(ForceDimensionArmTest, IsGivenBackWithoutAForce) {
  auto arm = opened(patient());
  ASSERT_TRUE(gives(*arm, {0, 0, 2}));
  arm.reset();
  EXPECT_EQ(force(), Vector3(Vector3::Zero()));
  EXPECT_FALSE(with([](DhdStubDevice& d) { return d.open || d.forces_on; }));
}

TEST_F(ForceDimensionArmTest, ThatCannotBeHadIsRefusedWithWhatToDo) {
  const auto refusal = [&](std::optional<int> serial) {
    auto settings = patient();
    settings.serial = serial;
    const auto arm = ForceDimensionArm::open(settings);
    EXPECT_FALSE(arm.has_value());
    return arm ? std::string() : arm.error().message;
  };
  const auto holds = [](const std::string& text, const char* words) {
    EXPECT_NE(text.find(words), std::string::npos) << words << " is not in: " << text;
  };
  holds(refusal(77), "there is no device 77, but omega.3 1001; name one of these or plug it in");
  with([](DhdStubDevice& d) { d.in_use = true; });
  holds(refusal({}), "can be opened (device is in use); plug it in");
  with([](DhdStubDevice& d) { d.plugged = false; });
  holds(refusal({}), "there is no device; plug it in");
  holds(refusal({}), "vendor 1451");
  with([](DhdStubDevice& d) { d.plugged = true; }, 2);
  holds(refusal({}), "but controller 1003");
  const auto first = with([](DhdStubDevice& d) {
    d.plugged = true;
    d.in_use = false;
    return d.times_opened;
  });
  const auto arm = opened(patient());
  holds(refusal({}), "this program uses it already");
  EXPECT_EQ(with([](DhdStubDevice& d) { return d.times_opened; }), first + 1);
  EXPECT_TRUE(gives(*arm, {0, 0, 1})) << "the one that has it keeps it";
}

TEST_F(ForceDimensionArmTest, IsAskedWhoItIsWithoutAForce) {
  const auto facts = probe_arm(patient());
  ASSERT_TRUE(facts.has_value()) << facts.error().message;
  EXPECT_EQ(facts->model, "omega.3");
  EXPECT_FALSE(with([](DhdStubDevice& d) { return d.open; }));
}

TEST_F(ForceDimensionArmTest, AnOldLibraryDoesWithoutAWatchdogAndOneThatLacksFunctionsIsRefused) {
  auto settings = patient();
  settings.library = DHD_STUB_DIR "/old/libdhd.so";
  const auto arm = opened(settings);
  EXPECT_FALSE(arm->facts().watchdog);
  EXPECT_EQ(arm->facts().peak_n, 12.0);
  EXPECT_TRUE(comes_true([&] { return arm->read().joints.allFinite(); }));
  settings.library = DHD_STUB_DIR "/lacking/libdhd.so";
  const auto lacking = ForceDimensionArm::open(settings);
  ASSERT_FALSE(lacking.has_value());
  EXPECT_NE(lacking.error().message.find("lacks dhdGetButtonMask; install version 3.17"), std::string::npos)
      << lacking.error().message;
}

TEST(ForceDimensionName, IsTheDriversOrHasASerialNumber) {
  EXPECT_FALSE(settings_of("forcedimension")->serial);
  EXPECT_EQ(settings_of("forcedimension:1001")->serial, 1001);
  for (const char* wrong : {"forcedimension:", "forcedimensionX", "forcedimensio", "forcedimension:x",
                            "forcedimension:1x", "forcedimension:70000", "forcedimension:-1"})
    EXPECT_FALSE(settings_of(wrong)) << wrong;
}

TEST_F(ForceDimensionArmTest, TheRigOfAnotherKindOfArmIsRefused) {
  setenv("PALPATE_LIBDHD", kStub, 1);
  device::DriverRegistry registry;
  add_to(registry);
  const auto phantom = registry.open(device::ArmRequest{.uri = "forcedimension", .nominal = {}});
  ASSERT_FALSE(phantom.has_value());
  EXPECT_NE(phantom.error().message.find("name a rig of this arm"), std::string::npos);
  device::ArmModel delta;
  delta.kind = device::ArmModel::Kind::cartesian;
  const auto arm = registry.open(device::ArmRequest{.uri = "forcedimension:1001", .nominal = delta});
  ASSERT_TRUE(arm.has_value()) << arm.error().message;
  EXPECT_EQ((*arm)->facts().identity, "forcedimension omega.3 1001");
  EXPECT_TRUE((*arm)->facts().states_place);
  EXPECT_EQ((*arm)->facts().peak_n, 12.0);
  EXPECT_EQ((*arm)->figures()["watchdog"], true);
  unsetenv("PALPATE_LIBDHD");
}

}  // namespace
}  // namespace palpate::drivers::forcedimension
