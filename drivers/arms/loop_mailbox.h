// Where the haptic loop and a driver's own loop meet: the newest reading, the newest force, and the account of what the
// motors were given. Neither waits for the other; nothing here locks, allocates or throws.
//
// What a fade has held back is not made up for later: it is told with each sample (ArmSample::withheld).
//
// Frames: ArmBase, as the device's samples and commands have it. SI. Threads: as each part says; one haptic loop, one
// driver's loop at a time.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>

#include "palpate/core/broadcast_ring.h"
#include "palpate/device/devices.h"
#include "palpate/device/force_strength.h"
#include "palpate/time/clock.h"

namespace palpate::drivers::arms {

inline std::int64_t now_ns() { return MonotonicClock<ArmClock>::monotonic_ns(); }
inline double seconds_between(std::int64_t then_ns, std::int64_t now_ns) {
  return to_seconds(Duration(now_ns - then_ns));
}

// When forces fade, and how they return.
struct LoopSettings {
  double watchdog_s = 0.005;  // samples and commands older than this do not count
  double fade_s = 0.020;      // from the full command to none where it is stale
  double ramp_s = 1.0;  // from none to the full command, at the start and after an outage that was not brief
};

// What a device measured at one moment.
struct Reading {
  std::int64_t stamp_ns = 0;       // monotonic
  std::array<double, 3> joints{};  // rad, or its place, m
  std::array<double, 3> gimbal{};  // rad
  std::uint32_t buttons = 0, unused = 0;
};

class LoopMailbox {
 public:
  explicit LoopMailbox(const LoopSettings& settings)
      : settings_(settings),
        strength_({.stale_s = settings.watchdog_s, .fade_s = settings.fade_s, .ramp_s = settings.ramp_s}) {}

  // --- the haptic loop
  // Not numbers while the device is lost or has told nothing for watchdog_s.
  device::ArmSample read() const;
  // What is no number counts as none.
  void command(const Vector3& force);

  // --- any thread, a signal handler too
  void let_go() noexcept { let_go_ns_.store(now_ns()); }
  void set_lost(bool lost) { lost_.store(lost, std::memory_order_release); }
  bool is_lost() const { return lost_.load(std::memory_order_acquire); }
  std::uint64_t stale_forces() const { return stale_forces_.load(); }
  std::uint64_t refused_commands() const { return refused_commands_.load(); }

  // --- the driver's loop
  // A device has been opened: readings from before are of another life, and forces start along the ramp.
  void start(std::int64_t now);
  void put(const Reading& reading);
  // Once a cycle: what may be commanded now. `allowed` is false while the device may not push. `sampled_ns` is the moment
  // of the newest reading that says where the force would go; where there is none, there is no force.
  Vector3 force_now(std::int64_t now, bool allowed, std::optional<std::int64_t> sampled_ns);
  // The device gives nothing any more; the next force begins along the ramp.
  void restart() { strength_.restart(); }
  // What the motors hold from now on, after force_now() of the same moment. Nothing: they hold something, but it is not
  // known how much; the account then takes it that they give what they were asked for.
  void tell_held(std::int64_t now, const Vector3& asked, const std::optional<Vector3>& held);

 private:
  struct CommandWire {
    std::int64_t sent_ns = 0;
    std::array<double, 3> force{};
  };
  // What the device has been given up to `stamp_ns`, and goes on being given.
  struct HeldWire {
    std::int64_t stamp_ns = 0;
    std::array<double, 3> impulse{}, force{};  // N s, N
    std::uint64_t known = 0;                   // 0: `force` is what was asked for
  };

  Vector3 withheld(const std::optional<HeldWire>& held, bool connected) const;  // the haptic loop's

  const LoopSettings settings_;

  // The driver's loop's own.
  device::ForceStrength strength_;
  std::int64_t last_force_ns_ = 0, last_held_ns_ = 0, last_sampled_ns_ = 0;
  Vector3 held_ = Vector3::Zero();          // N, since last_held_ns_
  Vector3 held_impulse_ = Vector3::Zero();  // N s, since the start

  // The haptic loop's own.
  Vector3 commanded_ = Vector3::Zero(), commanded_impulse_ = Vector3::Zero();  // N, N s up to:
  std::int64_t commanded_ns_ = 0;

  Mailbox<Reading> readings_;
  Mailbox<CommandWire> commands_;
  Mailbox<HeldWire> held_box_;
  std::atomic<bool> lost_{false};
  std::atomic<std::int64_t> started_ns_{0}, let_go_ns_{0};
  std::atomic<std::uint64_t> stale_forces_{0}, refused_commands_{0};
};

}  // namespace palpate::drivers::arms
