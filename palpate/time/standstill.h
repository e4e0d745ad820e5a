// Notices that a count which ought to go on stands still.
//
// Value; one thread; no allocation. It knows the time only as it is told, so that tests run on a virtual clock.
#pragma once

#include <cstdint>
#include <optional>

#include "palpate/time/instant.h"

namespace palpate::inline time {

template <typename C>
class Standstill {
 public:
  explicit Standstill(Duration patience) : patience_(patience) {}

  // `count` as it is at `now`. True while it has not moved on for so long as patience lasts; never before it
  // has begun to count.
  bool look(std::uint64_t count, Instant<C> now) {
    if (!moved_ || count != count_) moved_ = now;
    count_ = count;
    return count_ > 0 && now - *moved_ >= patience_;
  }

 private:
  Duration patience_;
  std::uint64_t count_ = 0;
  std::optional<Instant<C>> moved_;
};

}  // namespace palpate::inline time
