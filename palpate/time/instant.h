// A moment on one particular clock. Instants of different clocks do not mix; only a ClockModel leads from one
// to another. Integer nanoseconds, so that a day of running loses nothing.
#pragma once

#include <chrono>
#include <cmath>
#include <compare>
#include <cstdint>

namespace palpate::inline time {

using Duration = std::chrono::nanoseconds;

inline Duration seconds(double s) { return Duration(std::llround(s * 1e9)); }
inline constexpr double to_seconds(Duration d) { return static_cast<double>(d.count()) * 1e-9; }

// The clocks of the laboratory, as empty types.
struct TrueTime;       // the simulated world's own time; nobody outside the world reads it
struct PhysicsClock;   // host of the physics server: the reference of the whole system
struct GraphicsClock;  // host of the graphics server
struct ArmClock;       // the haptic arm's stamps
struct TrackerClock;   // the optical tracker's stamps
struct CameraClock;    // the camera's stamps (mid-exposure)

template <typename C>
struct Instant {
  Duration since_epoch{0};

  static Instant from_seconds(double s) { return {palpate::seconds(s)}; }
  double seconds() const { return to_seconds(since_epoch); }
  std::int64_t ns() const { return since_epoch.count(); }
  auto operator<=>(const Instant&) const = default;
  Instant& operator+=(Duration d) {
    since_epoch += d;
    return *this;
  }
};

template <typename C>
Instant<C> operator+(Instant<C> t, Duration d) {
  return {t.since_epoch + d};
}
template <typename C>
Instant<C> operator-(Instant<C> t, Duration d) {
  return {t.since_epoch - d};
}
template <typename C>
Duration operator-(Instant<C> a, Instant<C> b) {
  return a.since_epoch - b.since_epoch;
}

}  // namespace palpate::inline time
