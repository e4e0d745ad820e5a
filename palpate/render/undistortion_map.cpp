#include "palpate/render/undistortion_map.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/core/utility.hpp>

namespace palpate::render {
namespace {

constexpr unsigned kShares = 256, kHalf = kShares / 2;

// Eight values at once; both compilers make one instruction of an operation on them.
using Bytes8 = std::uint8_t __attribute__((vector_size(8)));
using Words8 = std::uint16_t __attribute__((vector_size(16)));

Words8 eight_from(const std::uint8_t* bytes) {
  Bytes8 loaded;
  std::memcpy(&loaded, bytes, sizeof loaded);
  return __builtin_convertvector(loaded, Words8);
}

unsigned mixed(unsigned a, unsigned b, unsigned share) {
  return (a * (kShares - share) + b * share + kHalf) / kShares;
}

}  // namespace

UndistortionMap::UndistortionMap(const device::CameraModel& camera) : camera_(camera) {
  const int width = camera.width, height = camera.height;
  sources_.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  // The left of two pixels and the right one's share.
  const auto between = [](double at, int count, unsigned& share) {
    const double kept = std::clamp(std::isfinite(at) ? at : 0.0, 0.0, count - 1.0);
    const int left = std::clamp(static_cast<int>(kept), 0, std::max(0, count - 2));
    share = static_cast<unsigned>(std::lround(kShares * (kept - left)));
    return left;
  };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Eigen::Vector2d seen = camera.distort({(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy});
      unsigned right = 0, below = 0;
      const int column = between(seen.x() * camera.fx + camera.cx, width, right);
      const int row = between(seen.y() * camera.fy + camera.cy, height, below);
      sources_.push_back({static_cast<std::uint32_t>(3 * (row * width + column)),
                          static_cast<std::uint16_t>(right), static_cast<std::uint16_t>(below)});
    }
}

bool UndistortionMap::is_of(const device::CameraModel& c) const { return !sources_.empty() && c == camera_; }

void UndistortionMap::undo_row(std::span<const std::uint8_t> image, int row, std::uint8_t* out) const {
  const std::size_t width = static_cast<std::size_t>(camera_.width);
  const std::size_t down = camera_.height > 1 ? 3 * width : 0, right = camera_.width > 1 ? 3 : 0;
  const Source* source = &sources_[width * static_cast<std::size_t>(row)];
  for (std::size_t x = 0; x < width; ++x, ++source, out += 3) {
    const std::uint8_t* upper = &image[source->first];
    if (source->first + down + sizeof(Bytes8) <= image.size()) {
      const auto below = static_cast<std::uint16_t>(source->below),
                 above = static_cast<std::uint16_t>(kShares - source->below);
      // Both columns' three values lie side by side: first down, then across. At most 255 * 256 + 128.
      const Words8 column =
          (eight_from(upper) * above + eight_from(upper + down) * below + std::uint16_t{kHalf}) >> 8;
      const Words8 next =
          right == 0 ? column : __builtin_shufflevector(column, column, 3, 4, 5, 6, 7, 0, 1, 2);
      const auto share = static_cast<std::uint16_t>(source->right),
                 rest = static_cast<std::uint16_t>(kShares - source->right);
      const Bytes8 mean =
          __builtin_convertvector((column * rest + next * share + std::uint16_t{kHalf}) >> 8, Bytes8);
      std::memcpy(out, &mean, 3);
    } else {
      for (std::size_t k = 0; k < 3; ++k)
        out[k] = static_cast<std::uint8_t>(
            mixed(mixed(upper[k], upper[k + down], source->below),
                  mixed(upper[k + right], upper[k + down + right], source->below), source->right));
    }
  }
}

void UndistortionMap::undo(std::span<const std::uint8_t> image, std::uint8_t* picture, int stride) const {
  const auto undo_rows = [&](const cv::Range& rows) {
    for (int row = rows.start; row < rows.end; ++row)
      undo_row(image, row, picture + 3 * static_cast<std::ptrdiff_t>(stride) * row);
  };
  cv::parallel_for_(cv::Range(0, camera_.height), undo_rows);
}

}  // namespace palpate::render
