#include "palpate/device/driver_registry.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace palpate::device {
namespace {

class StillArm : public ArmDevice {
 public:
  ArmSample read() override { return {}; }
  void command(const Vector3&) override {}
  void let_go() noexcept override {}
};

class OpenedStillArm : public OpenedArm {
 public:
  explicit OpenedStillArm(std::string name) : name_(std::move(name)) {}
  ArmDevice& device() override { return arm_; }
  ArmFacts facts() const override { return {.identity = name_, .peak_n = {}, .continuous_n = {}}; }

 private:
  StillArm arm_;
  std::string name_;
};

Driver arm_driver(std::string scheme, std::string form) {
  Driver driver;
  driver.scheme = std::move(scheme);
  driver.summary = "an arm that stands still";
  driver.arm = ArmOpener{std::move(form), {}, {}, [](const ArmRequest& request) {
                           return Expected<std::unique_ptr<OpenedArm>>(
                               std::make_unique<OpenedStillArm>(std::string(rest_of(request.uri))));
                         }};
  return driver;
}

Driver camera_driver(std::string scheme, std::string form) {
  Driver driver;
  driver.scheme = std::move(scheme);
  driver.summary = "a camera";
  driver.camera = CameraOpener{std::move(form), {}, {}, [](const CameraRequest&) {
                                 return Expected<std::unique_ptr<OpenedCamera>>(nullptr);
                               }};
  return driver;
}

TEST(DriverRegistry, ATextIsOpenedByTheDriverOfItsScheme) {
  DriverRegistry registry;
  registry.add(arm_driver("one", "one"));
  registry.add(arm_driver("two", "two or two:NAME"));
  auto arm = registry.open(ArmRequest{.uri = "two:Left", .nominal = {}});
  ASSERT_TRUE(arm) << arm.error().message;
  EXPECT_EQ((*arm)->facts().identity, "Left");
  EXPECT_EQ(registry.find_for("one")->scheme, "one");
  EXPECT_EQ(registry.find_for("three:x"), nullptr);
  EXPECT_EQ(rest_of("igtl://host:18944"), "//host:18944");
  EXPECT_EQ(rest_of("one"), "");
}

TEST(DriverRegistry, WhatNoDriverOpensIsWrongUseThatSaysWhatThereIs) {
  DriverRegistry registry;
  registry.add(arm_driver("one", "one"));
  registry.add(arm_driver("hidden", ""));
  registry.add(camera_driver("film", "film:FILE"));
  registry.add(arm_driver("two", "two or two:NAME"));
  registry.add(camera_driver("live", "live[:NAME]"));
  for (const char* uri : {"", "three", "One", "on", ":one", "film:x"}) {
    const auto none = registry.open(ArmRequest{.uri = uri, .nominal = {}});
    ASSERT_FALSE(none) << uri;
    EXPECT_EQ(none.error().exit_code(), 2);
    EXPECT_EQ(none.error().message, std::string("is '") + uri + "'; one, two or two:NAME is expected");
    EXPECT_EQ(registry.check(ArmRequest{.uri = uri, .nominal = {}}).error().message, none.error().message);
  }
  EXPECT_TRUE(registry.open(ArmRequest{.uri = "hidden", .nominal = {}}));
  EXPECT_EQ(registry.camera_forms(), "film:FILE or live[:NAME]");
  const auto no_tracker = registry.open(TrackerRequest{.uri = "igtl://host", .tools = {}});
  ASSERT_FALSE(no_tracker);
  EXPECT_EQ(no_tracker.error().message, "is 'igtl://host'; this program has no driver for such a device");
}

TEST(DriverRegistry, ADriverSaysWhichTextsAreDevicesAndTheSimulatedOnesCanBeLeftOut) {
  DriverRegistry registry;
  Driver computed = arm_driver("lab", "lab");
  computed.simulated = true;
  registry.add(computed);
  Driver real = arm_driver("real", "real or real:NAME");
  real.arm->names = [](std::string_view uri) { return uri != "real:"; };
  registry.add(real);
  EXPECT_EQ(registry.arm_forms(), "lab, real or real:NAME");
  EXPECT_EQ(registry.arm_forms(Offer::real), "real or real:NAME");
  EXPECT_TRUE(registry.names_arm("lab"));
  EXPECT_FALSE(registry.names_arm("lab", Offer::real));
  EXPECT_TRUE(registry.names_arm("real:x", Offer::real));
  EXPECT_FALSE(registry.names_arm("real:"));
  EXPECT_FALSE(registry.names_camera("real"));
  EXPECT_EQ(registry.open(ArmRequest{.uri = "real:", .nominal = {}}).error().message,
            "is 'real:'; lab, real or real:NAME is expected");
}

TEST(DriverRegistry, WhatAGuestThrowsOrLeavesOutIsItsRefusal) {
  DriverRegistry registry;
  Driver thrower = arm_driver("thrower", "thrower");
  thrower.arm->open = [](const ArmRequest&) -> Expected<std::unique_ptr<OpenedArm>> {
    throw std::runtime_error("no cable");
  };
  registry.add(thrower);
  registry.add(camera_driver("empty", "empty"));
  const auto thrown = registry.open(ArmRequest{.uri = "thrower", .nominal = {}});
  ASSERT_FALSE(thrown);
  EXPECT_EQ(thrown.error().exit_code(), 1);
  EXPECT_EQ(thrown.error().message, "device 'thrower': its driver fails: no cable");
  const auto nothing = registry.open(CameraRequest{.uri = "empty", .settings = {}});
  ASSERT_FALSE(nothing);
  EXPECT_NE(nothing.error().message.find("opens nothing"), std::string::npos);
}

TEST(DriverRegistry, ARequestIsCheckedBeforeItIsOpened) {
  DriverRegistry registry;
  Driver careful = arm_driver("careful", "careful:NAME");
  bool opened = false;
  careful.arm->check = [](const ArmRequest& request) -> Expected<void> {
    if (rest_of(request.uri).empty()) return wrong_use("'{}': a name is expected", request.uri);
    return {};
  };
  careful.arm->open = [&](const ArmRequest&) {
    opened = true;
    return Expected<std::unique_ptr<OpenedArm>>(std::make_unique<OpenedStillArm>(""));
  };
  registry.add(careful);
  EXPECT_EQ(registry.open(ArmRequest{.uri = "careful", .nominal = {}}).error().exit_code(), 2);
  EXPECT_FALSE(opened);
  EXPECT_TRUE(registry.open(ArmRequest{.uri = "careful:x", .nominal = {}}));
  EXPECT_TRUE(opened);
}

TEST(DriverRegistry, ADriverThatCannotBeUsedIsABrokenSetUp) {
  DriverRegistry registry;
  registry.add(arm_driver("one", "one"));
  const auto refuses = [&](const Driver& driver, const std::string& words) {
    try {
      registry.add(driver);
      ADD_FAILURE() << words;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  refuses(arm_driver("one", "one"), "another one of that scheme");
  for (const char* scheme : {"", "One", "1st", "a:b", "a b", "abcdefghijklmnopqrstuvwxyzabcdefg"})
    refuses(arm_driver(scheme, ""), "a scheme is");
  Driver wordless = arm_driver("two", "two");
  wordless.summary = "two\nlines";
  refuses(wordless, "a summary of one line");
  Driver bare;
  bare.scheme = "bare", bare.summary = "none";
  refuses(bare, "no device of any kind");
  Driver closed = arm_driver("closed", "closed");
  closed.arm->open = nullptr;
  refuses(closed, "without a way to open it");
  EXPECT_EQ(registry.drivers().size(), 1u);
}

}  // namespace
}  // namespace palpate::device
