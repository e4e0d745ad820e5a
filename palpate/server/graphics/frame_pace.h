// When a finished picture goes to the display: as old as nearly all of the last pictures were when they were ready, so that
// pictures follow each other as evenly as the camera's images were taken.
//
// One picture takes longer to draw than the next. Shown at once each, they come unevenly, and a motion that is even seems to
// stumble. Held until they have the same age they come evenly, and when a picture's light will leave is known before it is
// drawn. What it costs is the time that most pictures are held, a few milliseconds; it is bounded, and a picture that is late
// is shown at once. Time is passed in; one thread.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "palpate/time/clock.h"
#include "palpate/time/instant.h"

namespace palpate::server::graphics {

class FramePace {
 public:
  static constexpr std::size_t kJudged = 64;  // pictures: two seconds
  static constexpr std::size_t kFewest = 16;  // before so many are known nothing is held
  static constexpr double kReady = 0.9;       // of the pictures are ready at the age that is aimed at
  static constexpr Duration kBeyondMedian = std::chrono::microseconds(2500);  // that age at most
  static constexpr Duration kLongestHold = std::chrono::milliseconds(10);     // whatever clocks say

  // A picture of an image taken at `image_time` is ready at `ready`: when it is due, never before.
  Instant<GraphicsClock> due(Instant<GraphicsClock> image_time, Instant<GraphicsClock> ready);
  // The age that is aimed at; none: not known yet.
  std::optional<Duration> age() const { return age_; }

 private:
  void find_age();

  std::array<Duration, kJudged> ages_{};  // when they were ready, of the last pictures
  std::size_t pictures_ = 0;
  std::optional<Duration> age_;
};

}  // namespace palpate::server::graphics
