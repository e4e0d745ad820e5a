#include "palpate/evaluation/latency_meter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/device/timecode.h"

namespace palpate::evaluation {
namespace {

constexpr int kWidth = 320, kHeight = 120, kBlockPx = 14;

Instant<GraphicsClock> at_ms(double x) { return Instant<GraphicsClock>::from_seconds(1e-3 * x); }

// An image of the panel, exposed round this moment of the display's light.
device::CameraImage image_of(Duration middle, Duration exposure, int left = 25, int top = 30) {
  device::CameraImage image;
  image.width = kWidth;
  image.height = kHeight;
  image.rgb.assign(3 * kWidth * kHeight, 100);
  const auto light = device::timecode_light(middle, exposure);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      const double x = (u - left + 0.5) / kBlockPx, y = (v - top + 0.5) / kBlockPx;
      if (x < 0 || y < 0 || x >= device::kPanelWide || y >= device::kPanelHigh) continue;
      for (int k = 0; k < 3; ++k)
        image.rgb[static_cast<std::size_t>(3 * (v * kWidth + u) + k)] =
            static_cast<std::uint8_t>(std::lround(230.0 * std::sqrt(device::panel_light(x, y, light))));
    }
  return image;
}

server::graphics::FrameRecord frame_at(double arrived_ms, double begun_ms) {
  server::graphics::FrameRecord frame;
  frame.camera_frame = 77;
  frame.arrived = at_ms(arrived_ms);
  frame.begun = at_ms(begun_ms);
  return frame;
}

LatencyMeter meter_with_log(const LatencySettings& settings) {
  LatencyMeter meter(settings);
  for (int ms = 1000; ms < 3000; ++ms) meter.timecode_shown(at_ms(ms), std::chrono::milliseconds(ms));
  return meter;
}

TEST(LatencyMeter, TellsThePartsAndTheirSum) {
  auto meter =
      meter_with_log({.exposure = std::chrono::milliseconds(8), .scan_out = std::chrono::milliseconds(5)});
  // Light that left at 2000 ms of the timecode's time was handed over then; mid-exposure is scan-out later,
  // 2005.
  const auto delay =
      meter.look(image_of(seconds(2.0), std::chrono::milliseconds(8)), frame_at(2045, 2048), at_ms(2061));
  ASSERT_TRUE(delay) << delay.error().message;
  EXPECT_EQ(delay->camera_frame, 77u);
  const auto ms = [](Duration d) { return 1e3 * to_seconds(d); };
  EXPECT_NEAR(ms(delay->exposure), 4.0, 1e-6);
  EXPECT_NEAR(ms(delay->transfer), 36.0, 0.3);
  EXPECT_NEAR(ms(delay->wait), 3.0, 1e-6);
  EXPECT_NEAR(ms(delay->draw), 13.0, 1e-6);
  EXPECT_NEAR(ms(delay->scan_out), 5.0, 1e-6);
  EXPECT_NEAR(ms(delay->total()), 61.0, 0.3);
  EXPECT_EQ(meter.images(), 1u);
  EXPECT_EQ(meter.read(), 1u);
}

TEST(LatencyMeter, OfARollingShutterTheTimecodesRowsAreTakenBackToTheImagesMiddle) {
  const auto transfer_ms = [](Duration readout, int top) {
    auto meter = meter_with_log({.exposure = std::chrono::milliseconds(8), .readout = readout});
    const auto delay = meter.look(image_of(seconds(2.0), std::chrono::milliseconds(8), 25, top),
                                  frame_at(2045, 2048), at_ms(2061));
    EXPECT_TRUE(delay.has_value());
    return delay ? 1e3 * to_seconds(delay->transfer) : 0.0;
  };
  // The middle of the panel is row top + 28 of 120: of 40 ms of readout it saw (top + 28) / 120 - 1 / 2 later
  // than the middle, so that the image itself was taken by as much earlier or later.
  for (const int top : {5, 30, 55}) {
    const double later_ms = 40.0 * ((top + 0.5 * device::kPanelHigh * kBlockPx) / kHeight - 0.5);
    EXPECT_NEAR(transfer_ms(std::chrono::milliseconds(40), top) - transfer_ms(Duration(0), top), later_ms,
                0.2)
        << top;
  }
}

TEST(LatencyMeter, FindsOutTheExposureByItself) {
  auto meter = meter_with_log({});
  EXPECT_EQ(meter.exposure(), Duration(0));
  for (int i = 0; i < 15; ++i) {
    const double middle = 1.5 + 0.0371 * i;
    const auto delay = meter.look(image_of(seconds(middle), std::chrono::milliseconds(11)),
                                  frame_at(1e3 * middle + 40, 1e3 * middle + 41), at_ms(1e3 * middle + 50));
    ASSERT_TRUE(delay) << delay.error().message;
    EXPECT_NEAR(1e3 * to_seconds(delay->total()), 50.0, 0.7);
  }
  EXPECT_NEAR(1e3 * to_seconds(meter.exposure()), 11.0, 1.0);
}

TEST(LatencyMeter, FollowsAPanelThatMovesAndComesBack) {
  auto meter = meter_with_log({.exposure = std::chrono::milliseconds(8)});
  for (int i = 0; i < 4; ++i)
    EXPECT_TRUE(
        meter.look(image_of(seconds(1.9 + 0.03 * i), std::chrono::milliseconds(8), 5 + 12 * i, 5 + 9 * i),
                   frame_at(1940 + 30 * i, 1940 + 30 * i), at_ms(1950 + 30 * i)));
  device::CameraImage without = image_of(seconds(2.0), Duration(0));
  std::fill(without.rgb.begin(), without.rgb.end(), 100);
  const auto lost = meter.look(without, frame_at(2040, 2040), at_ms(2050));
  ASSERT_FALSE(lost);
  EXPECT_NE(lost.error().message.find("not found"), std::string::npos);
  EXPECT_FALSE(meter.trouble().empty());
  // Far from where it was.
  EXPECT_TRUE(meter.look(image_of(seconds(2.1), std::chrono::milliseconds(8), 40, 60), frame_at(2140, 2140),
                         at_ms(2150)));
  EXPECT_TRUE(meter.trouble().empty());
}

}  // namespace
}  // namespace palpate::evaluation
