// Memory of images that nobody needs any more, for a camera to fill its next ones into (CameraDevice::take_back). One
// thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace palpate::device {

class SparePixels {
 public:
  void keep(std::vector<std::uint8_t> pixels) {
    if (pixels.capacity() > 0 && kept_.size() < kMost) kept_.push_back(std::move(pixels));
  }
  // Of any size; empty where none is kept.
  std::vector<std::uint8_t> take() {
    if (kept_.empty()) return {};
    auto pixels = std::move(kept_.back());
    kept_.pop_back();
    return pixels;
  }

 private:
  static constexpr std::size_t kMost = 3;  // one is drawn, one waits, one was shown
  std::vector<std::vector<std::uint8_t>> kept_;
};

}  // namespace palpate::device
