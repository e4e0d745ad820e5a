#include "palpate/evaluation/timecode_finder.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>

#include "palpate/core/random.h"
#include "palpate/device/timecode.h"

namespace palpate::evaluation {
namespace {

constexpr int kWide = 480, kHigh = 320;

struct Look {
  double blur_px = 0.0, noise = 0.0;  // sd, grey levels
  double vignette = 0.0;              // light lost in the corners
  double veil = 0.0;                  // light of the room on the screen
  double brightness = 0.9;
};

// What lies on the screen at x, y (blocks of the panel), as light.
using Screen = std::function<double(double, double)>;

// An image of a screen whose panel has these corners; each pixel averages 3 x 3 rays, then blur and noise.
std::vector<std::uint8_t> photograph_of(const Screen& screen, const std::array<device::Pixel, 4>& panel,
                                        const Look& look, Random& random) {
  const Matrix3 to_screen = device::from_unit_square(panel).inverse();
  std::vector<double> light(static_cast<std::size_t>(kWide * kHigh));
  for (int v = 0; v < kHigh; ++v)
    for (int u = 0; u < kWide; ++u) {
      double sum = 0.0;
      for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) {
          const Eigen::Vector2d at = (to_screen * Vector3(u + i / 3.0, v + j / 3.0, 1.0)).hnormalized();
          sum += screen(at.x() * device::kPanelWide, at.y() * device::kPanelHigh);
        }
      const double x = (u - 0.5 * kWide) / (0.5 * kWide), y = (v - 0.5 * kHigh) / (0.5 * kWide);
      light[static_cast<std::size_t>(v * kWide + u)] =
          (look.veil + look.brightness * sum / 9.0) * (1.0 - look.vignette * (x * x + y * y));
    }
  // Separable blur.
  const int reach = static_cast<int>(std::ceil(3 * look.blur_px));
  for (const bool along : {true, false}) {
    if (reach == 0) break;
    auto out = light;
    for (int v = 0; v < kHigh; ++v)
      for (int u = 0; u < kWide; ++u) {
        double sum = 0.0, weights = 0.0;
        for (int d = -reach; d <= reach; ++d) {
          const int x = std::clamp(along ? u + d : u, 0, kWide - 1),
                    y = std::clamp(along ? v : v + d, 0, kHigh - 1);
          const double w = std::exp(-0.5 * d * d / (look.blur_px * look.blur_px));
          sum += w * light[static_cast<std::size_t>(y * kWide + x)], weights += w;
        }
        out[static_cast<std::size_t>(v * kWide + u)] = sum / weights;
      }
    light = out;
  }
  std::vector<std::uint8_t> rgb(3 * light.size());
  for (std::size_t i = 0; i < light.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      rgb[3 * i + k] = static_cast<std::uint8_t>(std::clamp(
          std::lround(255.0 * std::sqrt(std::max(0.0, light[i])) + random.normal(look.noise)), 0l, 255l));
  return rgb;
}

// A desktop with a bright window, stripes like lines of text, and the panel; on it the picture of itself.
Screen desktop(const device::TimecodeLight& timecode, const device::TimecodeLight& before) {
  return [timecode, before](double x, double y) {
    if (x >= 0 && y >= 0 && x < device::kPanelWide && y < device::kPanelHigh)
      return device::panel_light(x, y, timecode);
    const double nested_x = (x - 1.0) / 0.4, nested_y = (y - 8.0) / 0.4;  // the panel in the camera's picture
    if (nested_x >= 0 && nested_y >= 0 && nested_x < device::kPanelWide && nested_y < device::kPanelHigh)
      return 0.8 * device::panel_light(nested_x, nested_y, before);
    if (x > 12 && y > 6) return std::fmod(y, 0.8) < 0.3 && std::fmod(x, 1.7) < 1.2 ? 0.1 : 0.95;  // text
    if (x > 10 && x < 11 && y > 5 && y < 12) return 1.0;                                          // a bar
    return 0.15;
  };
}

// The timecode's true corners in the picture.
TimecodeCorners timecode_in(const std::array<device::Pixel, 4>& panel) {
  const Matrix3 H = device::from_unit_square(panel);
  TimecodeCorners c;
  const double x = device::kPanelRim / device::kPanelWide, y = device::kPanelRim / device::kPanelHigh;
  const std::array<device::Pixel, 4> at{device::Pixel(x, y), device::Pixel(1 - x, y),
                                        device::Pixel(1 - x, 1 - y), device::Pixel(x, 1 - y)};
  for (std::size_t i = 0; i < 4; ++i) c[i] = (H * at[i].homogeneous()).hnormalized();
  return c;
}

struct Case {
  const char* name;
  std::array<device::Pixel, 4> panel;
  Look look;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> list = {
      {"straight",
       {device::Pixel(90, 60), device::Pixel(356, 60), device::Pixel(356, 116), device::Pixel(90, 116)},
       {}},
      {"blurred and noisy",
       {device::Pixel(90, 60), device::Pixel(356, 60), device::Pixel(356, 116), device::Pixel(90, 116)},
       {2.0, 4.0, 0.0, 0.0, 0.9}},
      {"from the side",
       {device::Pixel(60, 50), device::Pixel(330, 92), device::Pixel(330, 126), device::Pixel(60, 116)},
       {1.0, 3.0, 0.3, 0.05, 0.8}},
      {"rolled by 12 degrees",
       {device::Pixel(80, 60), device::Pixel(350, 117), device::Pixel(338, 174), device::Pixel(68, 117)},
       {1.0, 3.0, 0.3, 0.05, 0.8}},
      {"in a lit room, dark corners",
       {device::Pixel(20, 20), device::Pixel(276, 26), device::Pixel(276, 80), device::Pixel(20, 74)},
       {1.0, 3.0, 0.5, 0.35, 0.4}},
      {"small",
       {device::Pixel(200, 150), device::Pixel(352, 150), device::Pixel(352, 182), device::Pixel(200, 182)},
       {0.7, 2.0, 0.2, 0.02, 0.9}},
      {"large",
       {device::Pixel(8, 100), device::Pixel(471, 96), device::Pixel(471, 196), device::Pixel(8, 200)},
       {1.5, 3.0, 0.3, 0.05, 0.8}},
  };
  return list;
}

TEST(TimecodeFinder, FindsThePanelAtASlantOutOfFocusAndPartlyLit) {
  Random random(1, "strip finder");
  const Duration exposure = std::chrono::milliseconds(8);
  for (const auto& c : cases()) {
    const Duration middle = seconds(random.uniform(0.0, 4.0));
    const auto rgb = photograph_of(desktop(device::timecode_light(middle, exposure),
                                           device::timecode_light(middle - seconds(0.09), exposure)),
                                   c.panel, c.look, random);
    const auto found = find_timecodes(rgb, kWide, kHigh);
    ASSERT_FALSE(found.empty()) << c.name;
    const auto truth = timecode_in(c.panel);
    const double block = (truth[1] - truth[0]).norm() / device::kTimecodeBlocks;
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_LT((found.front()[i] - truth[i]).norm(), 0.04 * block + 0.3) << c.name << ", corner " << i;
    const auto blocks = device::panel_blocks(rgb, kWide, kHigh, found.front());
    ASSERT_TRUE(blocks) << c.name << ": " << blocks.error().message;
    const auto reading = device::read_timecode(*blocks, exposure);
    ASSERT_TRUE(reading) << c.name << ": " << reading.error().message;
    EXPECT_LT(
        std::abs(to_seconds(device::timecode_difference(reading->middle, middle % device::kTimecodeCycle))),
        1e-3)
        << c.name;
  }
}

TEST(TimecodeFinder, LooksOnlyWhereItIsTold) {
  Random random(2, "strip finder");
  const auto& c = cases().front();
  const auto rgb =
      photograph_of(desktop(device::timecode_light(seconds(1), Duration(0)), {}), c.panel, {}, random);
  ASSERT_EQ(find_timecodes(rgb, kWide, kHigh, PictureArea{70, 40, 380, 140}).size(), 1u);
  EXPECT_TRUE(find_timecodes(rgb, kWide, kHigh, PictureArea{140, 40, 380, 140}).empty())
      << "cut by the area's edge";
  EXPECT_TRUE(find_timecodes(rgb, kWide, kHigh, PictureArea{400, 200, 800, 800}).empty());
  EXPECT_TRUE(find_timecodes(rgb, kWide, kHigh, PictureArea{-9, -9, 0, 0}).empty());
}

TEST(TimecodeFinder, WhereThereIsNoPanelItFindsNone) {
  Random random(3, "strip finder");
  const Look look{1.0, 4.0, 0.3, 0.05, 0.8};
  const auto& panel = cases().front().panel;
  // Text, bars, windows and their frames, but none with a timecode's shape.
  const Screen other = [](double x, double y) {
    const double frame_x = std::abs(x - 6.0), frame_y = std::abs(y - 4.0);
    if (std::max(frame_x, frame_y) < 3.0 && std::max(frame_x, frame_y) > 2.6) return 1.0;
    return std::fmod(y + 50, 0.8) < 0.3 && std::fmod(x + 50, 1.7) < 1.2 ? 0.1 : 0.9;
  };
  EXPECT_TRUE(find_timecodes(photograph_of(other, panel, look, random), kWide, kHigh).empty());
  EXPECT_TRUE(
      find_timecodes(photograph_of([](double, double) { return 0.3; }, panel, look, random), kWide, kHigh)
          .empty());
}

}  // namespace
}  // namespace palpate::evaluation
