#include "palpate/sim/camera_renderer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/units.h"
#include "palpate/math/looking.h"
#include "palpate/sim/lens_rays.h"
#include "palpate/sim/sensor_noise.h"

namespace palpate::sim {
namespace {

TrueView reference_view() {
  TrueView view;
  view.lens = {640, 480, 560, 561.5, 318.7, 242.1, {-0.28, 0.09, 0.001, -0.0005, 0.0}};
  view.X_world_camera = looking({0, -0.95, 2.30}, {0, -1.45, 1.40});
  view.table = {Vector3(-0.375, -1.52, 1.8), Vector3(0.375, -1.52, 1.8), Vector3(0.375, -1.52, 0.8),
                Vector3(-0.375, -1.52, 0.8)};
  view.wall = {Vector3(-0.375, -1.52, 0.8), Vector3(0.375, -1.52, 0.8), Vector3(0.375, -0.92, 0.8),
               Vector3(-0.375, -0.92, 0.8)};
  for (const double x : {-0.34, -0.12, 0.0, 0.34}) view.dots.push_back({{x, -1.52, 1.76}, Vector3::UnitY()});
  for (const double x : {-0.34, -0.2, 0.34}) view.dots.push_back({{x, -1.52, 0.95}, Vector3::UnitY()});
  for (const double x : {-0.30, -0.1, 0.1, 0.30}) view.dots.push_back({{x, -1.12, 0.80}, Vector3::UnitZ()});
  view.X_world_base = {Quaternion::Identity(), {0.10, -1.40, 1.75}};
  view.theta = {0.1, 0.3, 0.2};
  view.X_tip_marker = {Quaternion::Identity(), {-0.004, 0.018, 0.118}};
  view.marker_leds = {{0.06, 0, 0}, {-0.03, 0.052, 0}, {-0.03, -0.052, 0}};
  return view;
}

double linear(const std::vector<std::uint8_t>& rgb, const device::CameraModel& lens, int u, int v) {
  const double level = rgb[static_cast<std::size_t>(3 * (v * lens.width + u) + 1)] / 255.0;
  return level * level;  // pictures hold square roots of light
}

// Centre of light above the dark ring, in a window that ends inside the ring.
device::Pixel centre_of_light(const std::vector<std::uint8_t>& rgb, const device::CameraModel& lens,
                              const device::Pixel& near, double half_u, double half_v) {
  double sum = 0, x = 0, y = 0;
  for (int v = static_cast<int>(near.y() - half_v); v <= static_cast<int>(near.y() + half_v) + 1; ++v) {
    for (int u = static_cast<int>(near.x() - half_u); u <= static_cast<int>(near.x() + half_u) + 1; ++u) {
      const double du = (u - near.x()) / half_u, dv = (v - near.y()) / half_v;
      if (du * du + dv * dv > 1.0) continue;
      const double w = std::max(0.0, linear(rgb, lens, u, v) - 0.035);  // above the ring's own light
      sum += w, x += w * u, y += w * v;
    }
  }
  return {x / sum, y / sum};
}

TEST(CameraRenderer, DrawsDotsWhereTheCameraModelPutsThem) {
  CameraRenderer renderer;
  std::vector<std::uint8_t> rgb;
  TrueView view = reference_view();
  view.X_world_base.translation.x() += 3.0;  // neither arm nor shadow on any dot
  double squares = 0.0, worst = 0.0;
  Eigen::Vector2d bias = Eigen::Vector2d::Zero();
  int count = 0;
  for (const double shift : {-0.06, -0.013, 0.02, 0.055}) {  // sub-pixel places of every kind
    view.X_world_camera = looking({shift, -0.95 + 0.5 * shift, 2.3}, {0.0, -1.42, 1.40 + shift});
    renderer.render(view, rgb);
    ASSERT_EQ(rgb.size(), 640u * 480u * 3u);
    const Pose<CameraOptical, World> X = view.X_world_camera.inverse();
    for (const Dot& dot : view.dots) {
      const auto pixel = [&](const Vector3& p) { return view.lens.project((X * Point<World>{p}).m); };
      const device::Pixel expected = pixel(dot.centre);
      if (!(expected.x() > 20 && expected.x() < 620 && expected.y() > 20 && expected.y() < 460)) continue;
      const Vector3 along = dot.normal.y() > 0.5 ? Vector3(Vector3::UnitZ()) : Vector3(Vector3::UnitY());
      const double half_u = (pixel(dot.centre + 0.0085 * Vector3::UnitX()) - expected).norm();
      const double half_v = (pixel(dot.centre + 0.0085 * along) - expected).norm();
      const Eigen::Vector2d error = centre_of_light(rgb, view.lens, expected, half_u, half_v) - expected;
      bias += error;
      squares += error.squaredNorm();
      worst = std::max(worst, error.norm());
      ++count;
    }
  }
  ASSERT_GE(count, 30);
  // What is left: 8-bit levels and a window that cuts whole pixels (0.02 px), dots seen at a slant (0.01 px).
  EXPECT_LT(std::sqrt(squares / count), 0.05);
  EXPECT_LT(worst, 0.12);
  EXPECT_LT((bias / count).norm(), 0.02);  // half-pixel and flip mistakes show here
}

TEST(CameraRenderer, IsTheSameToTheBitAndNoiseFollowsItsSeed) {
  TrueView view = reference_view();
  view.noise_sd = 2.0;
  view.noise_seed = 7;
  std::vector<std::uint8_t> first, again, other;
  // Another renderer's memory, come back with its old content, must not be taken for one's own.
  for (int i = 0; i < 4; ++i) CameraRenderer().render(view, other);
  CameraRenderer a;
  a.render(view, first);
  EXPECT_EQ(first, other);
  {
    CameraRenderer b;  // fresh textures, other history
    TrueView before = view;
    before.theta = {0.4, 0.2, 0.1};
    b.render(before, again);
    b.render(view, again);
  }
  EXPECT_EQ(first, again);
  view.noise_seed = 8;
  a.render(view, other);
  EXPECT_NE(first, other);
}

TEST(CameraRenderer, ShowsArmAndItsShadowAndABoardInFront) {
  CameraRenderer renderer;
  TrueView view = reference_view();
  std::vector<std::uint8_t> rgb, moved;
  renderer.render(view, rgb);
  view.theta[0] = -0.5;
  renderer.render(view, moved);
  EXPECT_NE(rgb, moved);
  // A board square to the camera: the squares' middles alternate between dark and light.
  view.X_world_camera = {};
  view.lens.distortion = {};
  view.board = Pose<World, Board>{Quaternion::Identity(), {-0.1, -0.06, 0.6}};
  renderer.render(view, rgb);
  double previous = 0.0;
  for (int column = -1; column < 9; ++column) {
    const device::Pixel p = view.lens.project(Vector3(-0.1 + (column + 0.5) * 0.025, -0.06 + 0.0125, 0.6));
    const double level =
        linear(rgb, view.lens, static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
    if (column > -1) {
      EXPECT_GT(std::max(level, previous), 4.0 * std::min(level, previous)) << column;
    }
    previous = level;
  }
}

TEST(SensorNoise, HasTheStatedDeviationAndNoBias) {
  std::vector<std::uint8_t> grey(300000, 128);
  SensorNoise(2.0).add(grey, 3);
  double sum = 0, squares = 0;
  for (const auto g : grey) sum += g - 128.0, squares += (g - 128.0) * (g - 128.0);
  const double n = static_cast<double>(grey.size());
  EXPECT_NEAR(sum / n, 0.0, 5 * 2.0 / std::sqrt(n));
  // Rounding to whole levels adds 1/12 to the variance.
  EXPECT_NEAR(squares / n, 4.0 + 1.0 / 12.0, 5 * 4.0 * std::sqrt(2.0 / n));
  EXPECT_THROW(SensorNoise(-1.0), std::invalid_argument);
}

TEST(LensRays, AreTheInverseOfTheLens) {
  const device::CameraModel lens = reference_view().lens;
  const LensRays rays = lens_rays(lens);
  for (int v = 3; v < lens.height; v += 67) {
    for (int u = 5; u < lens.width; u += 71) {
      const Eigen::Vector2f ray = rays.ray[static_cast<std::size_t>(v * lens.width + u)];
      const device::Pixel back = lens.project(Vector3(ray.x(), ray.y(), 1.0));
      EXPECT_NEAR((back - device::Pixel(u, v)).norm(), 0.0, 1e-4);  // rays are kept in single precision
    }
  }
}

TEST(PixelBox, HoldsABentPolygonAlsoWhenItReachesBehindTheCamera) {
  const device::CameraModel lens = reference_view().lens;
  const std::vector<Vector3> polygon = {
      {-0.3, 0.1, 0.8}, {0.4, 0.1, 0.8}, {0.4, 0.3, -0.2}, {-0.3, 0.3, -0.2}};
  const auto box = pixel_box(lens, polygon);
  for (double a = 0; a <= 1.0; a += 0.05) {
    for (double b = 0; b <= 1.0; b += 0.05) {
      const Vector3 p =
          (1 - b) * ((1 - a) * polygon[0] + a * polygon[1]) + b * ((1 - a) * polygon[3] + a * polygon[2]);
      if (p.z() < 0.2) continue;
      const device::Pixel pixel = lens.project(p);
      if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > 639 || pixel.y() > 479) continue;
      EXPECT_TRUE(pixel.x() >= box[0] && pixel.x() <= box[0] + box[2] && pixel.y() >= box[1] &&
                  pixel.y() <= box[1] + box[3]);
    }
  }
  EXPECT_EQ(pixel_box(lens, {{0, 0, -1}, {1, 0, -1}, {1, 1, -1}})[2], 0);
}

}  // namespace
}  // namespace palpate::sim
