// The driver against a service over real sockets. Nothing here measures time: waits are for what must come, however long a
// busy machine takes.
#include "drivers/haply/arm.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "drivers/haply/driver.h"
#include "drivers/haply/service_for_tests.h"
#include "tests/comes_true.h"

namespace palpate::drivers::haply {
namespace {

using tests::comes_true;

ArmSettings settings_for(const ServiceForTests& service) {
  ArmSettings settings;
  settings.service.port = service.port();
  settings.loop.ramp_s = 0.0;
  return settings;
}

std::unique_ptr<HaplyArm> opened(const ServiceForTests& service) {
  auto arm = HaplyArm::open(settings_for(service));
  EXPECT_TRUE(arm.has_value()) << arm.error().message;
  return arm ? std::move(*arm) : nullptr;
}

bool is(const HaplyArm& arm, device::HealthCode code) {
  const auto health = arm.status().health;
  return health && health->code == code;
}

// As the haptic loop does: again and again.
template <typename Condition>
bool comes_true_while_pushing(HaplyArm& arm, const Vector3& force, Condition&& condition) {
  return comes_true([&] {
    arm.command(force);
    return condition();
  });
}

TEST(HaplyArm, TellsPlaceTurnAndButtons) {
  ServiceForTests service;
  const auto arm = opened(service);
  ASSERT_NE(arm, nullptr);
  EXPECT_EQ(arm->id(), "049D");
  const Vector3 gimbal(0.3, -0.4, 0.7);
  const Quaternion turn(Eigen::AngleAxisd(gimbal[0], Vector3::UnitY()) *
                        Eigen::AngleAxisd(gimbal[1], Vector3::UnitX()) *
                        Eigen::AngleAxisd(gimbal[2], Vector3::UnitZ()));
  service.move_to({0.01, -0.15, 0.2}, turn, true);
  device::ArmSample sample;
  ASSERT_TRUE(comes_true([&] {
    sample = arm->read();
    return sample.joints.allFinite() && sample.joints[0] == 0.01;
  }));
  EXPECT_EQ(Vector3(sample.joints), Vector3(0.01, -0.15, 0.2));
  EXPECT_LT((sample.gimbal - gimbal).norm(), 1e-12);
  EXPECT_EQ(sample.buttons, 2u);
  EXPECT_TRUE(sample.connected);
  EXPECT_TRUE(comes_true([&] { return arm->status().exchanges > 20; }));
  EXPECT_GT(arm->status().round_trip_s, 0.0);
  EXPECT_FALSE(arm->status().health);
  EXPECT_EQ(arm->config()["filters"]["force_gate"]["gain"], 0.3)
      << "it changes what is felt: told, not hidden";
}

TEST(HaplyArm, SetsItsAxesAndMountAndReadsThemBack) {
  ServiceForTests service;
  ASSERT_NE(opened(service), nullptr);
  const auto configured = service.configured();
  ASSERT_EQ(configured.size(), 1u);
  EXPECT_EQ(configured[0]["mount"]["transform"]["scale"]["x"], 1.0);
  const auto refuses = [&](const ServiceForTests::Faults& faults, const std::string& words) {
    service.set(faults);
    const auto arm = HaplyArm::open(settings_for(service));
    ASSERT_FALSE(arm.has_value()) << words;
    EXPECT_NE(arm.error().message.find(words), std::string::npos) << arm.error().message;
  };
  ServiceForTests::Faults other_axes, mounted, silent, no_arm;
  other_axes.axes = "XZY";
  refuses(other_axes, "keeps the axes XZY; XYZ is expected");
  mounted.mounted_at_x = 0.1;
  refuses(mounted, "keeps a mount");
  silent.tells_config = false;
  refuses(silent, "does not tell how it is configured");
  no_arm.has_arm = false;
  refuses(no_arm, "has no Inverse3; plug the arm in");
}

TEST(HaplyArm, PushesWhatIsCommandedAndLetsGoWhereNobodyCommands) {
  ServiceForTests service;
  const auto arm = opened(service);
  ASSERT_NE(arm, nullptr);
  const Vector3 force(0.5, -1.0, 2.0);
  ASSERT_TRUE(comes_true_while_pushing(*arm, force, [&] { return (service.force() - force).norm() < 1e-9; }));
  EXPECT_TRUE(comes_true_while_pushing(*arm, force, [&] {
    const auto held = arm->read().held;
    return held && (*held - force).norm() < 1e-9;
  })) << "as the service says what the arm gives";
  EXPECT_TRUE(comes_true([&] { return service.force() == Vector3::Zero(); }))
      << "no command any more: it fades";
  EXPECT_GT(arm->status().stale_exchanges, 0u);
  EXPECT_LE(service.largest_force(), force.norm() + 1e-9);
}

TEST(HaplyArm, LetsGoAtOnceWhenItIsTold) {
  ServiceForTests service;
  const auto arm = opened(service);
  ASSERT_NE(arm, nullptr);
  const Vector3 force(0.0, 0.0, 2.0);
  ASSERT_TRUE(comes_true_while_pushing(*arm, force, [&] { return (service.force() - force).norm() < 1e-9; }));
  arm->let_go();
  EXPECT_TRUE(comes_true([&] { return service.force() == Vector3::Zero(); }));
}

TEST(HaplyArm, WhatIsNoForceIsNone) {
  ServiceForTests service;
  const auto arm = opened(service);
  ASSERT_NE(arm, nullptr);
  const Vector3 nonsense(0.0, std::nan(""), 1.0);
  EXPECT_TRUE(comes_true_while_pushing(*arm, nonsense, [&] { return arm->status().refused_commands > 50; }));
  EXPECT_EQ(service.largest_force(), 0.0);
}

TEST(HaplyArm, AServiceThatGoesIsToldAndComesBackByItself) {
  auto service = std::make_unique<ServiceForTests>();
  const auto port = service->port();
  const auto arm = opened(*service);
  ASSERT_NE(arm, nullptr);
  service.reset();
  ASSERT_TRUE(comes_true([&] { return is(*arm, device::HealthCode::arm_lost); }));
  const auto sample = arm->read();
  EXPECT_FALSE(sample.connected);
  EXPECT_FALSE(sample.joints.allFinite());
  EXPECT_EQ(sample.held, Vector3(Vector3::Zero()));
  service = std::make_unique<ServiceForTests>(port);
  ASSERT_TRUE(comes_true([&] { return !arm->status().health && arm->read().joints.allFinite(); }));
  EXPECT_TRUE(arm->read().connected);
  EXPECT_EQ(arm->status().times_lost, 1u);
}

TEST(HaplyArm, AServiceThatHangsIsLostAndItsOldPlaceIsNobodys) {
  ServiceForTests service;
  const auto arm = opened(service);
  ASSERT_NE(arm, nullptr);
  ASSERT_TRUE(comes_true([&] { return arm->read().joints.allFinite(); }));
  service.hang(true);
  EXPECT_TRUE(comes_true([&] { return !arm->read().joints.allFinite(); }));
  EXPECT_TRUE(comes_true([&] { return is(*arm, device::HealthCode::arm_lost); }));
  EXPECT_NE(arm->status().health->words.find("took longer than 100 ms"), std::string::npos)
      << arm->status().health->words;
  service.hang(false);
  EXPECT_TRUE(comes_true([&] { return !arm->status().health; }));
}

TEST(HaplyArm, AnArmThatIsUnpluggedAndNonsenseAreLosses) {
  ServiceForTests service;
  const auto arm = opened(service);
  ASSERT_NE(arm, nullptr);
  ServiceForTests::Faults unplugged;
  unplugged.has_arm = false;
  service.set(unplugged);
  ASSERT_TRUE(comes_true([&] { return is(*arm, device::HealthCode::arm_lost); }));
  service.set({});
  ASSERT_TRUE(comes_true([&] { return !arm->status().health; }));
  ServiceForTests::Faults nonsense;
  nonsense.talks_nonsense = true;
  service.set(nonsense);
  ASSERT_TRUE(comes_true([&] { return arm->status().bad_states > 0; }));
  service.set({});
  EXPECT_TRUE(comes_true([&] { return !arm->status().health; }));
}

TEST(HaplyArm, WithoutCalibrationItHasNoPlaceAndWithoutPowerNoForce) {
  ServiceForTests service;
  const auto arm = opened(service);
  ASSERT_NE(arm, nullptr);
  ServiceForTests::Faults uncalibrated;
  uncalibrated.calibrated = false;
  service.set(uncalibrated);
  ASSERT_TRUE(comes_true([&] { return is(*arm, device::HealthCode::arm_uncalibrated); }));
  EXPECT_TRUE(comes_true([&] { return !arm->read().joints.allFinite(); }));
  ServiceForTests::Faults unpowered;
  unpowered.powered = false;
  service.set(unpowered);
  ASSERT_TRUE(comes_true([&] { return is(*arm, device::HealthCode::arm_forces_off); }));
  EXPECT_TRUE(comes_true([&] { return arm->read().joints.allFinite(); }));
  const auto before = service.commands();
  EXPECT_TRUE(comes_true_while_pushing(*arm, {0, 0, 3}, [&] { return service.commands() > before + 50; }));
  EXPECT_EQ(service.largest_force(), 0.0);
}

TEST(HaplyArm, IsNamedByItsIdAndItsService) {
  EXPECT_TRUE(settings_of("haply")->id.empty());
  EXPECT_EQ(settings_of("haply:049D")->id, "049D");
  EXPECT_EQ(settings_of("haply:049D")->service.port, 10001);
  EXPECT_EQ(settings_of("haply:@10.0.0.2:9000")->service.text(), "ws://10.0.0.2:9000/");
  EXPECT_EQ(settings_of("haply:A@localhost")->service.port, 10001);
  for (const char* wrong : {"haply:", "haplyX", "hapl", "haply:a@", "haply:a@host:", "haply:a@host:0",
                            "haply:a@host:99999", "haply:a@host:x"})
    EXPECT_FALSE(settings_of(wrong)) << wrong;
}

TEST(HaplyArm, TheRigOfAnotherKindOfArmIsRefused) {
  device::DriverRegistry registry;
  add_to(registry);
  ServiceForTests service;
  const std::string uri = fmt::format("haply:@127.0.0.1:{}", service.port());
  const auto phantom = registry.open(device::ArmRequest{.uri = uri, .nominal = {}});
  ASSERT_FALSE(phantom.has_value());
  EXPECT_NE(phantom.error().message.find("name a rig of this arm"), std::string::npos);
  device::ArmModel delta;
  delta.kind = device::ArmModel::Kind::cartesian;
  const auto arm = registry.open(device::ArmRequest{.uri = uri, .nominal = delta});
  ASSERT_TRUE(arm.has_value()) << arm.error().message;
  EXPECT_EQ((*arm)->facts().identity, "haply inverse3 049D");
  EXPECT_EQ((*arm)->figures()["driver"], "haply");
  const auto nobody = registry.open(device::ArmRequest{.uri = "haply:@127.0.0.1:9", .nominal = delta});
  ASSERT_FALSE(nobody.has_value());
  EXPECT_NE(nobody.error().message.find("check that the service runs"), std::string::npos)
      << nobody.error().message;
}

}  // namespace
}  // namespace palpate::drivers::haply
