#include "palpate/sim/device_faults.h"

#include <gtest/gtest.h>

namespace palpate::sim {
namespace {

device::CameraImage small_image() {
  device::CameraImage image;
  image.width = 4, image.height = 2;
  for (int i = 0; i < 3 * 4 * 2; ++i) image.rgb.push_back(static_cast<std::uint8_t>(i));
  return image;
}

std::vector<device::HealthCode> holding(const DeviceFaults& faults, double t) {
  std::vector<device::HealthCode> codes;
  for (const auto& [code, holds] : faults.at(t))
    if (holds) codes.push_back(code);
  return codes;
}

TEST(DeviceFaults, WithoutAnyNothingChanges) {
  const DeviceFaults faults(config::reference_world());
  for (double t = 0.0; t < 100.0; t += 0.25) {
    EXPECT_TRUE(holding(faults, t).empty());
    std::optional<device::CameraImage> image = small_image();
    faults.disturb(t, image);
    ASSERT_TRUE(image);
    EXPECT_EQ(image->rgb, small_image().rgb);
  }
}

TEST(DeviceFaults, AFaultHoldsFromItsBeginningUntilBeforeItsEnd) {
  auto world = config::reference_world();
  world.faults.camera_silent = {2.0, 3.0};
  const DeviceFaults faults(world);
  const auto silent = [&faults](double t) {
    std::optional<device::CameraImage> image = small_image();
    faults.disturb(t, image);
    return !image;
  };
  EXPECT_FALSE(silent(1.999));
  EXPECT_TRUE(silent(2.0));
  EXPECT_TRUE(silent(2.999));
  EXPECT_FALSE(silent(3.0));
  EXPECT_FALSE(silent(12.5));
}

TEST(DeviceFaults, ItComesAgainWhereThatIsAskedFor) {
  auto world = config::reference_world();
  world.faults.tracker_blind = {2.0, 3.0};
  world.faults.repeat_s = 10.0;
  const DeviceFaults faults(world);
  for (const double t : {2.5, 12.5, 1002.5}) {
    EXPECT_EQ(holding(faults, t), std::vector{device::HealthCode::tracker_blind}) << t;
  }
  for (const double t : {1.5, 3.5, 13.5, 1003.5}) EXPECT_TRUE(holding(faults, t).empty()) << t;
}

TEST(DeviceFaults, AnImageOfTheWrongSizeHasEverySecondPixelOfEverySecondRow) {
  auto world = config::reference_world();
  world.faults.image_size = {0.0, 1.0};
  std::optional<device::CameraImage> image = small_image();
  DeviceFaults(world).disturb(0.5, image);
  ASSERT_TRUE(image);
  EXPECT_EQ(image->width, 2);
  EXPECT_EQ(image->height, 1);
  EXPECT_EQ(image->rgb, (std::vector<std::uint8_t>{0, 1, 2, 6, 7, 8}));
}

TEST(DeviceFaults, ATrackerIsBlindForTheHeadsMarkerAloneAndItsClockGoesWrongForAll) {
  auto world = config::reference_world();
  world.faults.tracker_blind = {0.0, 1.0};
  world.faults.tracker_clock = {0.5, 1.0};
  world.faults.clock_jump_s = -2.0;
  std::vector<device::TrackerSample> samples(2);
  samples[0].marker = device::MarkerId::tip_marker;
  samples[1].marker = device::MarkerId::camera_marker;
  for (auto& sample : samples) sample.seen = true, sample.stamp = Instant<TrackerClock>::from_seconds(7.0);
  DeviceFaults(world).disturb(0.75, samples);
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_TRUE(samples[0].seen);
  EXPECT_FALSE(samples[1].seen);
  for (const auto& sample : samples) EXPECT_EQ(sample.stamp, Instant<TrackerClock>::from_seconds(5.0));
}

TEST(DeviceFaults, ASilentTrackerSaysNothingOfAnyMarker) {
  auto world = config::reference_world();
  world.faults.tracker_silent = {0.0, 1.0};
  std::vector<device::TrackerSample> samples(3);
  DeviceFaults(world).disturb(0.5, samples);
  EXPECT_TRUE(samples.empty());
}

}  // namespace
}  // namespace palpate::sim
