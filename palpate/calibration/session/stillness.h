// Whether a marker is held still, and whether it has been moved since it was last made use of.
//
// Held still: seen for `window_s`, its poses scattered about their mean by no more than `place` and `turn` (root of the mean square), and
// the means of the two halves of that time apart by no more than 0.6 of either. What a single pose is off does not count: a tracker's
// noise is several times larger at the far end of its volume. World frame, m, rad; times are the tracker's. One thread.
#pragma once

#include <deque>
#include <optional>
#include <span>

#include "palpate/device/devices.h"

namespace palpate::calibration::session {

struct StillnessSettings {
  double window_s = 0.4;
  double place = 0.4e-3, turn = 5e-3;  // a hand's tremor and a tracker's noise are below, a slow move is not
  double moved = 8e-3, turned = 0.08;  // either is a new pose
  double silent_s = 0.5;
};

class Stillness {
 public:
  explicit Stillness(device::MarkerId marker, StillnessSettings settings = {})
      : marker_(marker), settings_(settings) {}

  void add(const device::TrackerSample& sample);  // of other markers: nothing
  // What has arrived by `now_s`, on any clock that goes on. A tracker may say nothing of a marker that it does not see:
  // after `silent_s` without a word it is not seen.
  void watch(double now_s, std::span<const device::TrackerSample> samples);
  bool seen() const { return !window_.empty(); }
  bool still() const;
  // Since take(); true before the first.
  bool moved() const;
  void take();
  // The newest pose.
  std::optional<device::TrackerSample> newest() const;

 private:
  void lose();

  device::MarkerId marker_;
  StillnessSettings settings_;
  std::deque<device::TrackerSample> window_;
  bool whole_ = false;    // it has been seen throughout
  double heard_s_ = 0.0;  // when it was heard of last
  std::optional<device::TrackerSample> taken_;
};

}  // namespace palpate::calibration::session
