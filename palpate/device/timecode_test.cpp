#include "palpate/device/timecode.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/random.h"

namespace palpate::device {
namespace {

Duration us(double x) { return Duration(std::llround(1e3 * x)); }

double off_us(Duration found, Duration truth) {
  return 1e-3 * static_cast<double>(std::abs(timecode_difference(truth % kTimecodeCycle, found).count()));
}

TEST(Timecode, IsTheGrayCodeOfTheMilliseconds) {
  for (int ms = 0; ms < 4096; ++ms) {
    const auto light = timecode_light(std::chrono::milliseconds(ms) + us(300), Duration(0));
    const int gray = ms ^ (ms >> 1);
    for (int k = 0; k < kTimecodeBits; ++k)
      ASSERT_EQ(light[static_cast<std::size_t>(2 + k)], (gray >> k) & 1) << ms << ", bit " << k;
  }
}

TEST(Timecode, AnExposureShowsTheMeanOfItsMoments) {
  Random random(1, "strip");
  for (int run = 0; run < 100; ++run) {
    const Duration middle = us(random.uniform(10e3, 4.0e6)), exposure = us(random.uniform(1e3, 16e3));
    const auto mean = timecode_light(middle, exposure);
    TimecodeLight sum{};
    constexpr int kMoments = 2000;
    for (int i = 0; i < kMoments; ++i) {
      const auto now =
          timecode_light(middle + Duration(static_cast<Duration::rep>(((i + 0.5) / kMoments - 0.5) *
                                                                      static_cast<double>(exposure.count()))),
                         Duration(0));
      for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += now[k] / kMoments;
    }
    for (std::size_t k = 0; k < sum.size(); ++k) EXPECT_NEAR(mean[k], sum[k], 0.01) << k;
  }
}

TEST(Timecode, IsReadToAFractionOfAMillisecondThroughNoiseAndExposure) {
  Random random(2, "strip");
  for (const double exposure_ms : {0.5, 2.0, 8.0, 8.7, 15.0}) {
    double worst = 0.0;
    for (int run = 0; run < 30; ++run) {
      const Duration middle = us(random.uniform(0.0, 40e6)), exposure = us(1e3 * exposure_ms);
      auto blocks = timecode_light(middle, exposure);
      // Dim, on a grey ground, and each block's light known to 1 % of full scale.
      for (auto& b : blocks) b = 0.1 + 0.6 * b + random.normal(0.006);
      const auto reading = read_timecode(blocks, exposure);
      ASSERT_TRUE(reading) << reading.error().message;
      worst = std::max(worst, off_us(reading->middle, middle));
    }
    // The lowest bits that still change in one sense within an exposure tell the time by their grey.
    EXPECT_LT(worst, 1000.0) << exposure_ms << " ms";
    RecordProperty("worst_us_" + std::to_string(static_cast<int>(10 * exposure_ms)), std::to_string(worst));
  }
}

// A picture of the timecode seen at a slant: each pixel averages what 8 x 8 rays meet, then a blur, then
// noise.
std::vector<std::uint8_t> photograph(const TimecodeLight& light, const std::array<Pixel, 4>& c,
                                     double blur_px, double noise_sd, Random& random) {
  constexpr int kWidth = 320, kHeight = 80;
  std::vector<double> ideal(kWidth * kHeight, 0.2);
  // Inverse of the bilinear map, by Newton.
  const auto inside = [&](double u, double v, double& x, double& y) {
    x = y = 0.5;
    for (int i = 0; i < 8; ++i) {
      const Pixel top = (1 - x) * c[0] + x * c[1], bottom = (1 - x) * c[3] + x * c[2];
      const Pixel r = (1 - y) * top + y * bottom - Pixel(u, v);
      Eigen::Matrix2d J;
      J.col(0) = (1 - y) * (c[1] - c[0]) + y * (c[2] - c[3]);
      J.col(1) = bottom - top;
      const double det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0);
      x -= (J(1, 1) * r.x() - J(0, 1) * r.y()) / det;
      y -= (J(0, 0) * r.y() - J(1, 0) * r.x()) / det;
    }
    return x >= 0 && x < 1 && y >= 0 && y < 1;
  };
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      double sum = 0.0;
      for (int j = 0; j < 8; ++j)
        for (int i = 0; i < 8; ++i) {
          double x, y;
          sum += inside(u + (i - 3.5) / 8, v + (j - 3.5) / 8, x, y)
                     ? light[static_cast<std::size_t>(x * kTimecodeBlocks)]
                     : 0.2;
        }
      ideal[static_cast<std::size_t>(v * kWidth + u)] = sum / 64;
    }
  std::vector<std::uint8_t> rgb(3 * ideal.size());
  const int reach = static_cast<int>(std::ceil(3 * blur_px));
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u < kWidth; ++u) {
      double sum = 0.0, weights = 0.0;
      for (int dv = -reach; dv <= reach; ++dv)
        for (int du = -reach; du <= reach; ++du) {
          const int x = std::clamp(u + du, 0, kWidth - 1), y = std::clamp(v + dv, 0, kHeight - 1);
          const double w = blur_px > 0 ? std::exp(-0.5 * (du * du + dv * dv) / (blur_px * blur_px)) : 1.0;
          sum += w * ideal[static_cast<std::size_t>(y * kWidth + x)];
          weights += w;
        }
      for (int k = 0; k < 3; ++k)
        rgb[static_cast<std::size_t>(3 * (v * kWidth + u) + k)] = static_cast<std::uint8_t>(
            std::clamp(std::lround(255.0 * std::sqrt(sum / weights) + random.normal(noise_sd)), 0l, 255l));
    }
  return rgb;
}

TEST(Timecode, IsReadFromABlurredNoisySlantedPicture) {
  Random random(3, "strip");
  const std::array<Pixel, 4> corners{Pixel(20.3, 20.1), Pixel(180.8, 14.6), Pixel(181.9, 30.2),
                                     Pixel(19.6, 34.7)};
  double worst = 0.0;
  for (int run = 0; run < 4; ++run) {
    const Duration middle = us(random.uniform(0.0, 4.0e6)), exposure = std::chrono::milliseconds(8);
    const auto rgb = photograph(timecode_light(middle, exposure), corners, 1.5, 2.0, random);
    // Where it is is known to half a pixel.
    auto about = corners;
    for (auto& corner : about) corner += Pixel(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
    const auto blocks = timecode_blocks(rgb, 320, 80, about);
    ASSERT_TRUE(blocks) << blocks.error().message;
    const auto reading = read_timecode(*blocks, exposure);
    ASSERT_TRUE(reading) << reading.error().message;
    worst = std::max(worst, off_us(reading->middle, middle));
  }
  EXPECT_LT(worst, 1000.0);
  RecordProperty("worst_us", std::to_string(worst));
}

TEST(Timecode, DrawnOnAScreenItReadsBackToItsMillisecond) {
  for (const int ms : {0, 1, 777, 2047, 2048, 4095, 5000}) {
    std::vector<std::uint8_t> rgb(3 * 220 * 60, 90);
    draw_panel(rgb, 220, 60, 10, 12, 10, std::chrono::milliseconds(ms) + us(500));
    // Pixels are counted from the first one's centre.
    const double left = 10 + 15 - 0.5, right = left + 160, top = 12 + 15 - 0.5, bottom = top + 10;
    const auto blocks = timecode_blocks(
        rgb, 220, 60, {Pixel(left, top), Pixel(right, top), Pixel(right, bottom), Pixel(left, bottom)});
    ASSERT_TRUE(blocks);
    const auto reading = read_timecode(*blocks, Duration(0));
    ASSERT_TRUE(reading);
    EXPECT_LE(off_us(reading->middle, std::chrono::milliseconds(ms) + us(500)), 501.0) << ms;
  }
  std::vector<std::uint8_t> small(3 * 20 * 10, 90);
  draw_panel(small, 20, 10, -5, -5, 8, Duration(0));  // partly outside: cut, not crashed
}

TEST(Timecode, LightThatFallsOffAlongItIsTakenOut) {
  const auto bits = timecode_light(std::chrono::milliseconds(1365), Duration(0));
  TimecodeLight dimmed{};
  for (std::size_t i = 0; i < dimmed.size(); ++i) {
    const double share = static_cast<double>(i) / (kTimecodeBlocks - 1);
    dimmed[i] = (0.05 + 0.1 * share) + bits[i] * (0.7 - 0.5 * share);
  }
  const auto seen = timecode_bits(dimmed);
  ASSERT_TRUE(seen);
  for (std::size_t k = 0; k < seen->size(); ++k) EXPECT_NEAR((*seen)[k], bits[k + 2], 0.03) << k;
}

TEST(Timecode, ThePanelsMapTakesTheSquaresCornersAndKeepsLines) {
  const std::array<Pixel, 4> corners{Pixel(10, 20), Pixel(180, 5), Pixel(170, 60), Pixel(15, 44)};
  const Matrix3 H = from_unit_square(corners);
  const std::array<Pixel, 4> square{Pixel(0, 0), Pixel(1, 0), Pixel(1, 1), Pixel(0, 1)};
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_LT(((H * square[i].homogeneous()).hnormalized() - corners[i]).norm(), 1e-9);
  // The square's middle is where its diagonals cross, which perspective keeps.
  const Vector3 one = corners[0].homogeneous().cross(corners[2].homogeneous()),
                other = corners[1].homogeneous().cross(corners[3].homogeneous());
  const Pixel cross = one.cross(other).hnormalized();
  EXPECT_LT(((H * Vector3(0.5, 0.5, 1)).hnormalized() - cross).norm(), 1e-9);
}

TEST(Timecode, WhatIsNoTimecodeIsRefusedWithTheReason) {
  TimecodeLight dark{};
  EXPECT_NE(read_timecode(dark, Duration(0)).error().message.find("differ by 0.00"), std::string::npos);
  auto wrong = timecode_light(std::chrono::milliseconds(1234), Duration(0));
  for (const std::size_t k : {5u, 7u, 10u}) wrong[k] = 0.5;  // hidden behind something grey
  EXPECT_NE(read_timecode(wrong, Duration(0)).error().message.find("hides it"), std::string::npos);
  const std::vector<std::uint8_t> rgb(3 * 100 * 50, 0);
  EXPECT_NE(timecode_blocks(rgb, 100, 50, {Pixel(-3, 1), Pixel(90, 1), Pixel(90, 9), Pixel(1, 9)})
                .error()
                .message.find("outside the picture"),
            std::string::npos);
  EXPECT_NE(timecode_blocks(rgb, 100, 50, {Pixel(1, 1), Pixel(20, 1), Pixel(20, 9), Pixel(1, 9)})
                .error()
                .message.find("bring it nearer"),
            std::string::npos);
}

}  // namespace
}  // namespace palpate::device
