#include "palpate/record/session/recording_driver.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <thread>

#include "palpate/record/session/recorded_drivers.h"
#include "tests/scratch_folder.h"

namespace palpate::record::session {
namespace {

// A tracker and a camera whose every sample is known by its number.
struct NumberedTracker : device::OpenedTracker, device::TrackerDevice {
  device::TrackerDevice& device() override { return *this; }
  std::vector<device::TrackerSample> poll() override {
    device::TrackerSample sample;
    sample.seen = true;
    sample.stamp = {Duration(1'000'000 * ++number)};
    sample.translation = {0.001 * number, 1.0 / 3.0, 0.0};
    return {sample};
  }
  int number = 0;
};

struct NumberedCamera : device::OpenedCamera, device::CameraDevice {
  device::CameraDevice& device() override { return *this; }
  std::string name() const override { return "numbered"; }
  std::string description() const override { return "of a test"; }
  std::optional<device::CameraImage> poll() override {
    device::CameraImage image;
    image.frame = static_cast<std::uint64_t>(++number);
    image.mid_exposure = {Duration(33'000'000 * number)};
    image.width = 3;
    image.height = 2;
    image.rgb.assign(18, static_cast<std::uint8_t>(number));
    return image;
  }
  int number = 0;
};

constexpr int kSamples = 5;

std::filesystem::path recorded_session(const ScratchFolder& folder) {
  const auto file = folder / "session.mcap";
  device::DriverRegistry numbered;
  device::TrackerOpener tracker;
  tracker.form = "numbered";
  tracker.open = [](const auto&) -> Expected<std::unique_ptr<device::OpenedTracker>> {
    return std::make_unique<NumberedTracker>();
  };
  device::CameraOpener camera;
  camera.form = "numbered";
  camera.open = [](const auto&) -> Expected<std::unique_ptr<device::OpenedCamera>> {
    return std::make_unique<NumberedCamera>();
  };
  numbered.add(
      device::Driver{.scheme = "numbered", .summary = "of a test", .tracker = tracker, .camera = camera});
  const auto recording = std::move(*SessionRecording::begin(file, {.recorder = "test", .on_error = {}}));
  {
    const auto drivers = recorded_drivers(numbered, *recording, {.lossless = true});
    const auto tracked = std::move(*drivers.open(device::TrackerRequest{"numbered", {}}));
    const auto seen = std::move(*drivers.open(device::CameraRequest{"numbered", {}}));
    for (int i = 0; i < kSamples; ++i) {
      tracked->device().poll();
      seen->device().poll();
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }
  EXPECT_TRUE(recording->close()["dropped"].empty());
  return file;
}

device::DriverRegistry replaying() {
  device::DriverRegistry registry;
  add_to(registry);
  return registry;
}

// Until a device has given so much, or for a long while.
template <typename Look>
void look_until(Look look) {
  for (int i = 0; i < 2000 && !look(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

TEST(RecordingDriver, ItsTrackerGivesWhatWasGivenAtThePaceItCame) {
  const ScratchFolder folder;
  const auto file = recorded_session(folder);
  const auto registry = replaying();
  const auto tracker = registry.open(device::TrackerRequest{"recording:" + file.string(), {}});
  ASSERT_TRUE(tracker) << tracker.error().message;
  std::vector<device::TrackerSample> samples;
  const auto begun = std::chrono::steady_clock::now();
  look_until([&] {
    for (auto& sample : (*tracker)->device().poll()) samples.push_back(sample);
    return samples.size() == kSamples;
  });
  const auto took = std::chrono::steady_clock::now() - begun;
  ASSERT_EQ(samples.size(), static_cast<std::size_t>(kSamples));
  EXPECT_GE(took, std::chrono::milliseconds(20 * (kSamples - 1) - 5)) << "not sooner than it had come";
  for (int i = 0; i < kSamples; ++i) {
    EXPECT_EQ(samples[static_cast<std::size_t>(i)].stamp.ns(), 1'000'000 * (i + 1));
    EXPECT_EQ(samples[static_cast<std::size_t>(i)].translation.x(), 0.001 * (i + 1));
  }
  look_until([&] {
    (*tracker)->device().poll();
    return !(*tracker)->why_unheard().empty();
  });
  EXPECT_NE((*tracker)->why_unheard(), "");
}

TEST(RecordingDriver, ItsCameraShowsTheSamePicturesAndSaysWhenItHasEnded) {
  const ScratchFolder folder;
  const auto file = recorded_session(folder);
  const auto registry = replaying();
  const auto camera = registry.open(device::CameraRequest{"recording:" + file.string() + "#left", {}});
  ASSERT_TRUE(camera) << camera.error().message;
  std::vector<device::CameraImage> images;
  look_until([&] {
    if (auto image = (*camera)->device().poll()) images.push_back(std::move(*image));
    return (*camera)->ended();
  });
  ASSERT_FALSE(images.empty());
  for (const auto& image : images) {
    EXPECT_EQ(image.mid_exposure.ns(), 33'000'000 * static_cast<std::int64_t>(image.frame));
    EXPECT_EQ(image.rgb, std::vector<std::uint8_t>(18, static_cast<std::uint8_t>(image.frame)));
  }
  EXPECT_EQ(images.back().frame, static_cast<std::uint64_t>(kSamples));
  ASSERT_TRUE((*camera)->health());
  EXPECT_EQ((*camera)->health()->code, device::HealthCode::recording_ended);
}

TEST(RecordingDriver, WhatARecordingDoesNotHoldIsRefusedInWords) {
  const ScratchFolder folder;
  const auto file = recorded_session(folder).string();
  const auto registry = replaying();
  const auto arm = registry.open(device::ArmRequest{.uri = "recording:" + file, .nominal = {}});
  ASSERT_FALSE(arm);
  EXPECT_NE(arm.error().message.find("nothing of an arm"), std::string::npos) << arm.error().message;
  EXPECT_FALSE(registry.open(device::CameraRequest{"recording:" + file + "#right", {}}));
  EXPECT_FALSE(registry.open(device::TrackerRequest{"recording:/nowhere.mcap", {}}));
  EXPECT_FALSE(registry.names_tracker("recording:"));
}

}  // namespace
}  // namespace palpate::record::session
