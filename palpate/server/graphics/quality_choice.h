// With which quality pictures are drawn, chosen from what the frame loop misses.
//
// Where images are missed while drawing takes a good part of their interval, the next lower level is drawn from then on.
// Where none is missed and drawing takes so little that a level five times as dear would fit as well, the next higher
// one is tried. A level that had to be left is tried again after 20 s, then after twice as long each time, and only
// where it would fit if it were as dear as it was found to be. Images that
// the camera lost while the loop had nothing to do are not the drawing's. Pure, deterministic; one thread.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "palpate/render/compositor.h"
#include "palpate/time/instant.h"

namespace palpate::server::graphics {

class QualityChoice {
 public:
  static constexpr std::size_t kJudged = 30;   // frames after which too many missed images tell
  static constexpr std::size_t kCalm = 150;    // frames without one, after which more is tried
  static constexpr std::size_t kSettled = 10;  // frames after a change that say nothing: shaders are compiled
  static constexpr double kDearer = 5.0;       // than the level below, until it was tried
  static constexpr Duration kFirstWait = std::chrono::seconds(20), kLongestWait = std::chrono::minutes(10);

  explicit QualityChoice(render::Quality first) : quality_(first) {}
  render::Quality quality() const { return quality_; }
  std::uint64_t changes() const { return changes_; }

  // A frame was drawn from the camera's image number `camera_frame`, exposed at `stamp`, and drawing it took `busy`.
  // Where the quality is another one from now on: why, for the screen.
  std::optional<std::string> frame(Instant<GraphicsClock> now, Duration busy, std::uint64_t camera_frame,
                                   Instant<CameraClock> stamp);

 private:
  struct Frame {
    Duration busy, interval;  // of the camera's images
    int missed;               // images since the frame before
  };
  std::optional<Frame> judged(Duration busy, std::uint64_t camera_frame, Instant<CameraClock> stamp);
  // Of the last `count` frames.
  int missed(std::size_t count) const;
  double busy_share(std::size_t count, double quantile) const;
  void change(render::Quality quality);

  struct Attempt {
    Instant<GraphicsClock> not_before;
    Duration wait = kFirstWait;
    double dearer = kDearer;
  };
  render::Quality quality_;
  std::uint64_t changes_ = 0;
  std::array<Attempt, 3> attempts_;  // of each level
  double share_below_ = 0.0;         // of an interval, before this level was tried; 0: it was not
  std::optional<std::uint64_t> last_frame_;
  Instant<CameraClock> last_stamp_;
  std::size_t unsettled_ = kSettled;
  std::deque<Frame> frames_;  // the newest last, kCalm at most
};

}  // namespace palpate::server::graphics
