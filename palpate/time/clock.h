// Something that tells the time and can be waited on: the machine's monotonic clock, or a virtual one that
// moves only when its owner says so. All behaviour is written against Clock, so that tests run on the virtual
// one.
#pragma once

#include <errno.h>
#include <time.h>

#include "palpate/time/instant.h"

namespace palpate::inline time {

template <typename C>
class Clock {
 public:
  virtual ~Clock() = default;
  virtual Instant<C> now() const = 0;
  // Returns when now() >= t. A virtual clock is single-threaded and jumps there instead of waiting.
  virtual void sleep_until(Instant<C> t) = 0;
};

// CLOCK_MONOTONIC, optionally shown with an offset and a drift, so that one machine can play two hosts whose
// clocks differ by a known truth. Safe from any thread.
template <typename C>
class MonotonicClock : public Clock<C> {
 public:
  MonotonicClock() = default;
  // Reads now = base + (1 + drift) (t - base) + offset of the monotonic time t.
  MonotonicClock(double offset_s, double drift_ppm, std::int64_t base_ns = 0)
      : offset_ns_(std::llround(offset_s * 1e9)), rate_(1.0 + drift_ppm * 1e-6), base_ns_(base_ns) {}

  Instant<C> now() const override { return from_monotonic(monotonic_ns()); }
  void sleep_until(Instant<C> t) override {
    const std::int64_t target = to_monotonic(t);
    timespec spec{static_cast<time_t>(target / 1'000'000'000), static_cast<long>(target % 1'000'000'000)};
    // Again only after a signal. A time before the machine's start is no error here: it is over.
    while (target > 0 && clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &spec, nullptr) == EINTR) {
    }
  }
  Instant<C> from_monotonic(std::int64_t ns) const {
    return {Duration(base_ns_ + offset_ns_ + std::llround(rate_ * static_cast<double>(ns - base_ns_)))};
  }
  std::int64_t to_monotonic(Instant<C> t) const {
    return base_ns_ + std::llround(static_cast<double>(t.ns() - base_ns_ - offset_ns_) / rate_);
  }
  static std::int64_t monotonic_ns() {
    timespec spec{};
    clock_gettime(CLOCK_MONOTONIC, &spec);
    return static_cast<std::int64_t>(spec.tv_sec) * 1'000'000'000 + spec.tv_nsec;
  }

 private:
  std::int64_t offset_ns_ = 0;
  double rate_ = 1.0;
  std::int64_t base_ns_ = 0;
};

template <typename C>
class VirtualClock : public Clock<C> {
 public:
  explicit VirtualClock(Instant<C> start = {}) : now_(start) {}
  Instant<C> now() const override { return now_; }
  void sleep_until(Instant<C> t) override {
    if (t > now_) now_ = t;
  }
  void advance(Duration d) { now_ += d; }

 private:
  Instant<C> now_;
};

}  // namespace palpate::inline time
