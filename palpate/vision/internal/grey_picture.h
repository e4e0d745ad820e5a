// A grey image as OpenCV takes it. Pure; safe from any thread.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>

namespace palpate::vision {

// Whether so many bytes are an image of this size, row 0 on top, no gaps between rows.
inline bool holds(std::span<const std::uint8_t> grey, int width, int height) {
  return width > 0 && height > 0 &&
         grey.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

// A view of it, not a copy: only to be read.
inline cv::Mat picture_of(std::span<const std::uint8_t> grey, int width, int height) {
  return {height, width, CV_8UC1, const_cast<std::uint8_t*>(grey.data())};
}

}  // namespace palpate::vision
