// One arm and the threads that meet at it: the exchange with the service, and the haptic loop.
//
// Which thread may call what stands with each part; they meet in mailboxes and atomics. How it behaves: arm.h.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "drivers/haply/arm.h"
#include "drivers/haply/protocol.h"
#include "palpate/core/broadcast_ring.h"
#include "palpate/device/force_strength.h"
#include "palpate/time/clock.h"

namespace palpate::drivers::haply {

inline std::int64_t now_ns() { return MonotonicClock<ArmClock>::monotonic_ns(); }

class HaplyArm::Connection {
 public:
  explicit Connection(const ArmSettings& settings)
      : settings_(settings),
        id_(settings.id),
        strength_({.stale_s = settings.watchdog_s, .fade_s = settings.fade_s, .ramp_s = settings.ramp_s}) {}
  ~Connection();

  // --- an ordinary thread
  Expected<void> begin();
  ArmStatus status() const;
  const std::string& id() const { return id_; }
  Json config() const;

  // --- the haptic loop
  device::ArmSample read() const;
  void command(const Vector3& force);

  // --- any thread, a signal handler too
  void let_go() noexcept { let_go_ns_.store(now_ns()); }

 private:
  struct SampleWire {
    std::int64_t stamp_ns = 0;
    std::array<double, 3> place{}, gimbal{}, held{};
    std::uint32_t buttons = 0, tells_held = 0;
  };
  struct CommandWire {
    std::int64_t sent_ns = 0;
    std::array<double, 3> force{};
  };

  // --- the exchange's thread; begin() before it starts
  void run();
  bool wait_for(std::chrono::nanoseconds time);  // true: asked to end
  Expected<void> connect();
  Expected<void> exchange();
  Vector3 force_now(std::int64_t now);
  void take(const ServiceState& state, std::int64_t stamp_ns);
  void lose(const Error& error);

  const ArmSettings settings_;
  std::string id_;

  // The exchange's own.
  std::unique_ptr<web::WebSocketClient> socket_;
  device::ForceStrength strength_;
  std::int64_t last_sample_ns_ = 0, last_exchange_ns_ = 0;
  bool calibrated_ = true, powered_ = true;

  Mailbox<SampleWire> samples_;
  Mailbox<CommandWire> commands_;
  std::atomic<bool> lost_{false}, uncalibrated_{false}, unpowered_{false};
  std::atomic<std::int64_t> connected_ns_{0}, let_go_ns_{0};
  std::atomic<double> round_trip_s_{0.0};
  std::atomic<std::uint64_t> exchanges_{0}, stale_exchanges_{0}, refused_commands_{0}, bad_states_{0},
      times_lost_{0};

  mutable std::mutex words_guard_;
  std::string trouble_;  // why it is lost
  Json config_;

  std::mutex sleep_guard_;
  std::condition_variable sleep_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace palpate::drivers::haply
