// Holds what goes from the virtual world to the hand back by a fixed time, on purpose: for experiments with
// haptic delay.
//
// Fixed size: push() neither locks, allocates nor throws. Times of what comes out are shifted by the delay,
// so that a delayed impact is played whole and in its place. One thread.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "palpate/haptics/haptic_loop.h"

namespace palpate::server::physics {

class DelayLine {
 public:
  // A fifth of a second at up to 5 kHz.
  static constexpr std::size_t kPlaces = 1024;
  static constexpr Duration kMost = std::chrono::milliseconds(200);

  void set(Duration delay) { delay_ = delay; }
  Duration delay() const { return delay_; }

  // Takes the input of `now` in and gives out the newest that is due; nothing while the line fills. An input
  // that comes when all places are taken drops the oldest.
  std::optional<haptics::HapticInput> push(const haptics::HapticInput& input, Instant<PhysicsClock> now) {
    if (delay_ == Duration(0)) return input;
    if (count_ == kPlaces) drop();
    places_[(first_ + count_) % kPlaces] = {now, input};
    ++count_;
    std::optional<haptics::HapticInput> due;
    while (count_ > 0 && now - places_[first_].taken >= delay_) {
      due = places_[first_].input;
      drop();
    }
    if (due) {
      due->impact.start += delay_;
      for (auto& impact : due->earlier) impact.start += delay_;
      due->time += delay_;
    }
    return due;
  }

 private:
  struct Place {
    Instant<PhysicsClock> taken;
    haptics::HapticInput input;
  };
  void drop() { first_ = (first_ + 1) % kPlaces, --count_; }

  Duration delay_{0};
  std::array<Place, kPlaces> places_{};
  std::size_t first_ = 0, count_ = 0;
};

}  // namespace palpate::server::physics
