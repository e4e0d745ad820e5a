#include "palpate/desktop/drawing.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <numeric>

namespace palpate::desktop {
namespace {

constexpr Colour kInk{200, 100, 50, 255};

// In pixels: how much of the canvas is covered.
double covered(const Canvas& canvas) {
  double sum = 0.0;
  for (std::size_t i = 3; i < canvas.rgba.size(); i += 4) sum += canvas.rgba[i] / 255.0;
  return sum;
}

TEST(Drawing, CoversAsMuchAsAFigureIsLarge) {
  Canvas line(200, 100), steep(100, 200), ring(120, 120), disc(120, 120), polygon(100, 100), dashes(200, 20);
  draw_line(line, {20, 20}, {180, 80}, 4.0, kInk);
  const double caps = std::numbers::pi * 4.0;  // half a circle of radius 2 at either end
  EXPECT_NEAR(covered(line), 4.0 * std::hypot(160.0, 60.0) + caps, 12.0);
  draw_line(steep, {20, 20}, {80, 180}, 4.0, kInk);
  EXPECT_NEAR(covered(steep), covered(line), 12.0);
  draw_disc(disc, {60, 60}, 40.0, kInk);
  EXPECT_NEAR(covered(disc), std::numbers::pi * 1600.0, 30.0);
  draw_ring(ring, {60, 60}, 40.0, 6.0, kInk);
  EXPECT_NEAR(covered(ring), 2.0 * std::numbers::pi * 40.0 * 6.0, 30.0);
  const std::array<Eigen::Vector2d, 4> corners{{{10, 20}, {70, 20}, {90, 60}, {30, 60}}};
  fill_polygon(polygon, corners, kInk);
  EXPECT_NEAR(covered(polygon), 60.0 * 40.0, 45.0);
  draw_dashes(dashes, {10, 10}, {190, 10}, 2.0, 10.0, kInk);
  EXPECT_NEAR(covered(dashes), 9.0 * (2.0 * 10.0 + std::numbers::pi), 6.0);
  EXPECT_EQ(dashes.at(15, 10)[3], 255);
  EXPECT_EQ(dashes.at(25, 10)[3], 0);
}

TEST(Drawing, LeavesOutWhatLiesBeyondTheCanvasOrIsNoNumber) {
  Canvas canvas(40, 30);
  const double none = std::numeric_limits<double>::quiet_NaN();
  draw_line(canvas, {none, 3}, {20, 20}, 3.0, kInk);
  draw_ring(canvas, {5, none}, 8.0, 3.0, kInk);
  draw_line(canvas, {-500, -50}, {900, -50}, 9.0, kInk);
  draw_disc(canvas, {1e9, 10}, 5.0, kInk);
  EXPECT_EQ(covered(canvas), 0.0);
  draw_line(canvas, {-1000, 15}, {1000, 15}, 2.0, kInk);
  EXPECT_NEAR(covered(canvas), 80.0, 1.0);
}

TEST(Drawing, ScalesAPictureWithoutMovingIt) {
  // Left half red, right half blue, the lower half darker.
  constexpr Size kPicture{8, 4};
  std::vector<std::uint8_t> rgb;
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 8; ++x)
      for (const int value : {x < 4 ? 200 : 0, 0, x < 4 ? 0 : 200})
        rgb.push_back(static_cast<std::uint8_t>(y < 2 ? value : value / 2));
  Canvas canvas(100, 60);
  draw_picture(canvas, rgb, kPicture, {10, 10, 80, 40});
  EXPECT_EQ(canvas.at(12, 12), (std::array<std::uint8_t, 4>{200, 0, 0, 255}));
  EXPECT_EQ(canvas.at(87, 12), (std::array<std::uint8_t, 4>{0, 0, 200, 255}));
  EXPECT_EQ(canvas.at(12, 47), (std::array<std::uint8_t, 4>{100, 0, 0, 255}));
  EXPECT_NEAR(canvas.at(49, 12)[0], canvas.at(50, 12)[2], 12);  // the edge stays in the middle
  EXPECT_EQ(canvas.at(9, 12)[3], 0);
  EXPECT_EQ(canvas.at(90, 12)[3], 0);
  // Partly beyond the canvas.
  Canvas small(20, 20);
  draw_picture(small, rgb, kPicture, {-40, -20, 80, 40});
  EXPECT_EQ(small.at(10, 10), (std::array<std::uint8_t, 4>{0, 0, 100, 255}));
}

TEST(Drawing, LaysOneCanvasOverAnother) {
  Canvas below(10, 10), piece(4, 4);
  below.rectangle(0, 0, 10, 10, {100, 100, 100, 255});
  piece.rectangle(0, 0, 2, 4, kInk);
  put(below, piece, 8, 8);
  EXPECT_EQ(below.at(8, 8), (std::array<std::uint8_t, 4>{200, 100, 50, 255}));
  EXPECT_EQ(below.at(7, 8), (std::array<std::uint8_t, 4>{100, 100, 100, 255}));
  std::vector<std::uint8_t> rgb;
  to_rgb(below, rgb);
  ASSERT_EQ(rgb.size(), 300u);
  EXPECT_EQ(rgb[3 * 88], 200);
  EXPECT_EQ(rgb[3 * 88 + 2], 50);
}

}  // namespace
}  // namespace palpate::desktop
