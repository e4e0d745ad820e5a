// For tests: pictures that a person has looked at, kept as files beside this one. PALPATE_DRAW_GOLDEN_PICTURES=1 draws them anew; look at
// them before they are kept.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "palpate/core/file.h"
#include "palpate/render/context.h"
#include "palpate/render/picture_file.h"

namespace palpate {

enum class Golden {
  exact,  // where the renderer is the one that drew it; alike elsewhere
  alike,  // what is drawn was computed in a way that rounding decides
};

inline std::string this_renderer() {
  const auto context = render::Context::required();
  return context->renderer() + "\n" + context->version() + "\n";
}

inline void compare_with_golden(const std::string& name, const std::vector<std::uint8_t>& rgb, int width,
                                int height, Golden how = Golden::exact) {
  const std::filesystem::path folder = PALPATE_GOLDEN_PICTURES, path = folder / (name + ".png");
  if (std::getenv("PALPATE_DRAW_GOLDEN_PICTURES") != nullptr) {
    ASSERT_TRUE(render::write_png(path, rgb, width, height));
    ASSERT_TRUE(write_file(folder / "renderer.txt", this_renderer()));
  }
  const cv::Mat kept = cv::imread(path.string(), cv::IMREAD_COLOR);
  ASSERT_TRUE(kept.cols == width && kept.rows == height) << path;
  double sum = 0.0;
  int different = 0, far = 0;
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u)
      for (int c = 0; c < 3; ++c) {
        const int ours = rgb[static_cast<std::size_t>(3 * (v * width + u) + c)];
        const int error = std::abs(ours - kept.at<cv::Vec3b>(v, u)[2 - c]);  // OpenCV has blue first
        sum += error, different += error > 0, far += error > 24;
      }
  const auto renderer = read_file(folder / "renderer.txt");
  ASSERT_TRUE(renderer);
  const int bytes = 3 * width * height;
  if (how == Golden::exact && *renderer == this_renderer()) {
    EXPECT_EQ(different, 0) << name << ": on the renderer that drew it";
  } else {
    // Other sample places at edges, other rounding inside.
    EXPECT_LT(sum / bytes, 1.0) << name;
    EXPECT_LT(far, bytes / 100) << name;
  }
}

}  // namespace palpate
