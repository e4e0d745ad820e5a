// The number of a frame that never wraps, from a camera's counter that does.
#pragma once

#include <cstdint>

namespace palpate::drivers::cameras {

class FrameCount {
 public:
  // Counters run from `first` to `last` and then again from `first`: GigE Vision 1.x 1 to 65535 (0 is never
  // sent), V4L2 0 to 2^32 - 1.
  FrameCount(std::uint64_t first, std::uint64_t last) : first_(first), period_(last - first + 1) {}
  // Frames taken so far; a gap is a lost frame. The counter begins anew with a camera that was opened again:
  // call restart(), and the count goes on after what was counted.
  std::uint64_t count(std::uint64_t raw) {
    const std::uint64_t place = (raw - first_) % period_;
    if (!begun_)
      begun_ = true, ++frames_;
    else
      frames_ += (place + period_ - place_) % period_;
    place_ = place;
    return frames_;
  }
  void restart() { begun_ = false; }

 private:
  std::uint64_t first_, period_, place_ = 0, frames_ = 0;
  bool begun_ = false;
};

}  // namespace palpate::drivers::cameras
