// Holds values back by a fixed time, on purpose: for experiments with haptic delay.
//
// Fixed size: push() neither locks, allocates nor throws. Times inside what comes out are its taker's to shift.
// One thread.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "palpate/time/instant.h"

namespace palpate::inline time {

template <typename T>
class DelayLine {
 public:
  // A fifth of a second at up to 5 kHz.
  static constexpr std::size_t kPlaces = 1024;
  static constexpr Duration kMost = std::chrono::milliseconds(200);

  void set(Duration delay) { delay_ = delay; }
  Duration delay() const { return delay_; }

  // Takes the value of `now` in and gives out the newest that is due; nothing while the line fills. A value
  // that comes when all places are taken drops the oldest.
  std::optional<T> push(const T& value, Instant<PhysicsClock> now) {
    if (delay_ == Duration(0)) return value;
    if (count_ == kPlaces) drop();
    places_[(first_ + count_) % kPlaces] = {now, value};
    ++count_;
    std::optional<T> due;
    while (count_ > 0 && now - places_[first_].taken >= delay_) {
      due = places_[first_].value;
      drop();
    }
    return due;
  }

 private:
  struct Place {
    Instant<PhysicsClock> taken;
    T value;
  };
  void drop() { first_ = (first_ + 1) % kPlaces, --count_; }

  Duration delay_{0};
  std::array<Place, kPlaces> places_{};
  std::size_t first_ = 0, count_ = 0;
};

}  // namespace palpate::inline time
