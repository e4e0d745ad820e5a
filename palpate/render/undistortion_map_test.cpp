// The lens undone beside the formula in double precision, pixel by pixel.
#include "palpate/render/undistortion_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "palpate/core/random.h"

namespace palpate::render {
namespace {

std::vector<std::uint8_t> noise_of(int width, int height) {
  Random random(1, "undistortion");
  std::vector<std::uint8_t> image(static_cast<std::size_t>(3 * width * height));
  for (auto& byte : image) byte = static_cast<std::uint8_t>(random.uniform(0.0, 255.99));
  return image;
}

double expected(const std::vector<std::uint8_t>& image, const device::CameraModel& c, int x, int y, int k) {
  const Eigen::Vector2d seen = c.distort({(x - c.cx) / c.fx, (y - c.cy) / c.fy});
  const double u = std::clamp(seen.x() * c.fx + c.cx, 0.0, c.width - 1.0),
               v = std::clamp(seen.y() * c.fy + c.cy, 0.0, c.height - 1.0);
  const int left = std::min(static_cast<int>(u), c.width - 2),
            top = std::min(static_cast<int>(v), c.height - 2);
  const auto at = [&](int column, int row) {
    return static_cast<double>(image[static_cast<std::size_t>(3 * (row * c.width + column) + k)]);
  };
  const double a = u - left, b = v - top;
  return (1 - b) * ((1 - a) * at(left, top) + a * at(left + 1, top)) +
         b * ((1 - a) * at(left, top + 1) + a * at(left + 1, top + 1));
}

// Barrel, pincushion with tangential parts, and a lens that looks far beyond its own rim.
TEST(UndistortionMap, EveryPixelIsThatOfTheLens) {
  for (const auto& lens :
       {device::LensCoefficients{-0.28, 0.09}, device::LensCoefficients{0.12, -0.05, 0.002, -0.003, 0.01},
        device::LensCoefficients{1.5}}) {
    const device::CameraModel camera{64, 48, 55.0, 56.0, 30.7, 24.1, lens};
    const auto image = noise_of(camera.width, camera.height);
    const int stride = camera.width + 5;
    std::vector<std::uint8_t> picture(static_cast<std::size_t>(3 * stride * camera.height), 7);
    const UndistortionMap map(camera);
    map.undo(image, picture.data(), stride);
    for (int y = 0; y < camera.height; ++y) {
      for (int x = 0; x < camera.width; ++x)
        for (int k = 0; k < 3; ++k)
          // Shares of 1/256, rounded twice, of two ways across 255.
          ASSERT_NEAR(picture[static_cast<std::size_t>(3 * (y * stride + x) + k)],
                      expected(image, camera, x, y, k), 2.1)
              << x << ' ' << y;
      for (int x = camera.width; x < stride; ++x)
        ASSERT_EQ(picture[static_cast<std::size_t>(3 * (y * stride + x))], 7) << "beside the picture";
    }
  }
}

TEST(UndistortionMap, WithoutALensItIsTheImage) {
  const device::CameraModel camera{33, 17, 40.0, 40.0, 16.0, 8.0, {}};
  const auto image = noise_of(camera.width, camera.height);
  std::vector<std::uint8_t> picture(image.size());
  UndistortionMap(camera).undo(image, picture.data(), camera.width);
  EXPECT_EQ(picture, image);
}

TEST(UndistortionMap, IsOfOneCamera) {
  const device::CameraModel camera{33, 17, 40.0, 40.0, 16.0, 8.0, {-0.1}};
  device::CameraModel other = camera;
  const UndistortionMap map(camera);
  EXPECT_TRUE(map.is_of(camera));
  other.distortion[0] = -0.11;
  EXPECT_FALSE(map.is_of(other));
  EXPECT_FALSE(UndistortionMap().is_of(camera));
}

}  // namespace
}  // namespace palpate::render
