#include "palpate/device/borrowed_devices.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace palpate::device {
namespace {

class Arm : public ArmDevice {
 public:
  ArmSample read() override { return {}; }
  void command(const Vector3& force) override { commanded = force; }
  void let_go() noexcept override {}
  Vector3 commanded = Vector3::Zero();
};

class Camera : public CameraDevice {
 public:
  std::optional<CameraImage> poll() override { return std::nullopt; }
};

TEST(BorrowedDevices, AreOpenedByTheirNameAndAreThoseThatWereGiven) {
  Arm arm;
  Camera camera, right;
  DriverRegistry registry;
  registry.add(borrowed_devices("mine", {.arm = &arm,
                                         .arm_facts = {.identity = "my arm", .peak_n = 2.0},
                                         .camera = &camera,
                                         .right_camera = &right}));
  auto opened = registry.open(ArmRequest{.uri = "mine", .nominal = {}});
  ASSERT_TRUE(opened) << opened.error().message;
  (*opened)->device().command({1.0, 2.0, 3.0});
  EXPECT_EQ(arm.commanded, Vector3(1.0, 2.0, 3.0));
  EXPECT_EQ((*opened)->facts().peak_n, 2.0);
  EXPECT_FALSE((*opened)->facts().simulated) << "nobody said so";
  auto eye = registry.open(CameraRequest{.uri = "mine"});
  ASSERT_TRUE(eye) << eye.error().message;
  EXPECT_EQ(&(*eye)->device(), &camera);
  EXPECT_EQ(*(*eye)->right(), &right);
}

TEST(BorrowedDevices, OfAKindThatIsNotThereNoneIsOffered) {
  Arm arm;
  DriverRegistry registry;
  registry.add(borrowed_devices("mine", {.arm = &arm}));
  EXPECT_FALSE(registry.open(HandRequest{"mine"}));
  EXPECT_FALSE(registry.names_camera("mine"));
  EXPECT_FALSE(registry.names_arm("mine:other"));
  EXPECT_THROW(registry.add(borrowed_devices("nothing", {})), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::device
