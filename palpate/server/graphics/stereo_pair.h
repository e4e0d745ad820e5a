// Which images of two cameras belong together: those taken at the same moment.
//
// The cameras expose together (a trigger, or one world) and their images take about the same time to come, as
// those of two cameras of one make; but each loses images of its own and its images come
// in their own time. A left image waits for the right one of its moment; where that was lost the left one is
// left out too: an eye whose picture stands still while the other's moves hurts. Where no right image has
// fitted for a while - it is silent, or exposes when it likes - left images go on alone, until one fits
// again. One image waits at most, the newest.
// Host time of the graphics server. One thread.
#pragma once

#include <deque>
#include <optional>

#include "palpate/device/devices.h"
#include "palpate/time/instant.h"

namespace palpate::server::graphics {

class StereoPair {
 public:
  // Moments this far apart are the same one: half the interval of cameras at 60 Hz.
  static constexpr Duration kSameMoment = std::chrono::milliseconds(8);
  // The right camera is given up after so long without an image that fits, and so many left ones.
  static constexpr Duration kPatience = std::chrono::milliseconds(250);
  static constexpr int kMostUnfitted = 3;

  struct Timed {
    device::CameraImage image;
    Instant<GraphicsClock> at, time;  // arrival; mid-exposure as its camera's clock has it
    Duration moment{0};               // mid-exposure on a time line that both cameras have in common
  };
  struct Images {
    Timed left;
    std::optional<device::CameraImage> right;
  };

  void left(Timed image);
  void right(Timed image);
  // What may be drawn now, once.
  std::optional<Images> take(Instant<GraphicsClock> now);

  // Left images go on alone, as of the last take().
  bool right_lost() const { return lost_; }
  // Left images that were left out.
  std::uint64_t unpaired() const { return unpaired_; }

 private:
  static constexpr std::size_t kMostWaiting = 4;  // right images, should the left camera's be late
  std::optional<Timed> left_;
  std::deque<Timed> right_;
  std::optional<Instant<GraphicsClock>> fitted_;  // the last right image that did; first the begin
  std::optional<Duration> alone_;                 // moment of the left image that went on alone last
  int unfitted_ = 0;                              // left images since
  bool lost_ = false;
  std::uint64_t unpaired_ = 0;
};

}  // namespace palpate::server::graphics
