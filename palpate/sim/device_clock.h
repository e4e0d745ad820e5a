// The true reading of one device's clock: what a clock estimator has to find out.
//
// True time runs with the physics host's clock, the reference of the whole system. Values, safe from any
// thread.
#pragma once

#include "palpate/sim/config/world_file.h"
#include "palpate/time/instant.h"

namespace palpate::sim {

template <typename C>
class DeviceClock {
 public:
  DeviceClock() = default;
  explicit DeviceClock(const config::ClockSettings& settings)
      : offset_ns_(std::llround(settings.offset_s * 1e9)), drift_(settings.drift) {}

  Instant<C> at(Instant<TrueTime> t) const {
    return {Duration(t.ns() + offset_ns_ + std::llround(drift_ * static_cast<double>(t.ns())))};
  }
  Instant<TrueTime> true_time(Instant<C> t) const {
    const std::int64_t since = t.ns() - offset_ns_;
    return {Duration(since - std::llround(drift_ / (1.0 + drift_) * static_cast<double>(since)))};
  }

 private:
  std::int64_t offset_ns_ = 0;
  double drift_ = 0.0;
};

inline Instant<PhysicsClock> physics_time(Instant<TrueTime> t) { return {t.since_epoch}; }
inline Instant<TrueTime> true_time(Instant<PhysicsClock> t) { return {t.since_epoch}; }

}  // namespace palpate::sim
