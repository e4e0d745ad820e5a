// The lens undone in the shader, beside OpenCV's remap of the same image, for every kind of lens the
// calibration gives: k1 k2 p1 p2 k3 with and without k3.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "palpate/render/compositor.h"

namespace palpate {
namespace {

// At most about 12 grey levels from pixel to pixel in either direction: see the tolerance below.
device::CameraImage waves(int width, int height) {
  device::CameraImage image;
  image.width = width, image.height = height;
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      for (int c = 0; c < 3; ++c)
        image.rgb.push_back(static_cast<std::uint8_t>(
            std::lround(128.0 + 60.0 * std::sin(0.11 * u + c) + 60.0 * std::cos(0.09 * v + 0.05 * u - c))));
  return image;
}

struct NamedLens {
  const char* name;
  device::LensCoefficients distortion;
};

class Undistortion : public testing::TestWithParam<NamedLens> {};

TEST_P(Undistortion, IsThatOfOpenCvToItsFractionsOfAPixel) {
  for (const auto& [width, height, focus] : {std::tuple{640, 480, 560.0}, std::tuple{1280, 720, 900.0}}) {
    const device::CameraModel lens{
        width, height, focus, 1.003 * focus, 0.5 * width - 3.3, 0.5 * height + 5.1, GetParam().distortion};
    device::CameraImage image = waves(width, height);
    render::Compositor compositor;
    std::vector<std::uint8_t> ours;
    compositor.draw(image, lens, {}, {}, {}, ours);

    const cv::Matx33d k(lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1);
    const auto& d = lens.distortion;
    cv::Mat map_u, map_v, theirs;
    cv::initUndistortRectifyMap(k, cv::Vec<double, 5>(d[0], d[1], d[2], d[3], d[4]), cv::noArray(), k,
                                {width, height}, CV_32FC1, map_u, map_v);
    cv::remap(cv::Mat(height, width, CV_8UC3, image.rgb.data()), theirs, map_u, map_v, cv::INTER_LINEAR,
              cv::BORDER_REPLICATE);
    double sum = 0.0;
    int worst = 0;
    for (std::size_t i = 0; i < ours.size(); ++i) {
      const int error = std::abs(static_cast<int>(ours[i]) - static_cast<int>(theirs.data[i]));
      sum += error;
      worst = std::max(worst, error);
    }
    // OpenCV rounds places to 1/32 px, the card to 1/256: at 12 levels per pixel 0.2 levels in each
    // direction, and each rounds its own levels.
    EXPECT_LE(worst, 2) << GetParam().name << " " << width;
    EXPECT_LT(sum / static_cast<double>(ours.size()), 0.3) << GetParam().name << " " << width;
  }
}

INSTANTIATE_TEST_SUITE_P(Lenses, Undistortion,
                         testing::Values(NamedLens{"none", {0, 0, 0, 0, 0}},
                                         NamedLens{"barrel", {-0.28, 0.09, 0.001, -0.0005, 0.0}},
                                         NamedLens{"barrel_with_k3", {-0.35, 0.18, 0.0008, 0.0012, -0.06}},
                                         NamedLens{"pincushion", {0.12, -0.05, -0.001, 0.002, 0.02}},
                                         NamedLens{"tilted", {-0.05, 0.0, 0.012, -0.009, 0.0}}),
                         [](const auto& lens) { return std::string(lens.param.name); });

}  // namespace
}  // namespace palpate
