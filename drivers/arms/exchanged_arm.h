// An arm that is told a force and asked for its state a thousand times a second, by a thread of this object which connects
// again by itself.
//
// The haptic loop never waits for it (loop_mailbox.h). A force reaches the arm up to one exchange later. What can go wrong
// is a state, told by status(): while there is no fresh sample read() gives places that are not numbers, at which the haptic
// loop fades its forces; while there is no fresh command this object fades them itself. A device that is gone is said to be
// gone (ArmSample::connected): forces stay off until somebody re-arms.
//
// Frames: ArmBase is the arm's own axes. SI. Threads: read() and command() by the haptic loop, status() by an ordinary one.
#pragma once

#include <condition_variable>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/arms/loop_mailbox.h"
#include "palpate/core/expected.h"
#include "palpate/device/health.h"

namespace palpate::drivers::arms {

// What an arm says of itself that keeps it from its work. In static memory.
struct Complaint {
  device::HealthCode code;
  const char* words;  // after the arm's name: "is not calibrated; hold it at its rest"
};

struct ExchangedState {
  Reading reading;
  bool knows_its_place = true;  // else `reading` is not used
  bool may_push = true;
  std::optional<Vector3> held;           // N, what its motors give, where it can tell
  const Complaint* complaint = nullptr;  // the worst; null: none
};

// A connection to a device; used by one thread at a time. Gives no force any more and lets the device go when it ends.
class ArmLink {
 public:
  virtual ~ArmLink() = default;
  // Says a force, N, and hears the state. Refused: the device is lost, with what to do; the link is then given up.
  virtual Expected<ExchangedState> exchange(const Vector3& force) = 0;
};
using ConnectArm = std::function<Expected<std::unique_ptr<ArmLink>>()>;

struct ExchangedArmSettings {
  LoopSettings loop{};
  std::string name;         // "arm haply", which begins what is said of it
  std::string thread_name;  // "palpate-haply"
};

struct ExchangedArmStatus {
  // arm_lost, or what the arm complains of; none: it runs.
  std::optional<device::HealthReport> health;
  std::uint64_t exchanges = 0, stale_exchanges = 0, refused_commands = 0, times_lost = 0;
  double round_trip_s = 0.0;  // mean of the last second or so
};

class ExchangedArm : public device::ArmDevice {
 public:
  // Connects, and returns once the arm has told its state. From an ordinary thread.
  static Expected<std::unique_ptr<ExchangedArm>> open(ExchangedArmSettings settings, ConnectArm connect);
  ~ExchangedArm() override;

  // Stamped in the machine's monotonic clock.
  device::ArmSample read() override { return mailbox_.read(); }
  void command(const Vector3& force) override { mailbox_.command(force); }
  void let_go() noexcept override { mailbox_.let_go(); }

  ExchangedArmStatus status() const;

 private:
  ExchangedArm(ExchangedArmSettings settings, ConnectArm connect);

  // --- the exchange's thread
  // `first` hears how the first connection went; where it failed the thread ends.
  void run(std::promise<Expected<void>> first);
  bool wait_until(std::chrono::steady_clock::time_point time);  // true: asked to end
  Expected<void> connect();
  Expected<void> exchange();
  void lose(const Error& error);

  const ExchangedArmSettings settings_;
  const ConnectArm connect_;
  LoopMailbox mailbox_;

  // The exchange's own.
  std::unique_ptr<ArmLink> link_;
  std::optional<std::int64_t> sampled_ns_;
  bool may_push_ = false;

  std::atomic<const Complaint*> complaint_{nullptr};
  std::atomic<double> round_trip_s_{0.0};
  std::atomic<std::uint64_t> exchanges_{0}, times_lost_{0};

  mutable std::mutex words_guard_;
  std::string trouble_;  // why it is lost

  std::mutex sleep_guard_;
  std::condition_variable sleep_;
  bool ending_ = false;
  std::thread thread_;
};

}  // namespace palpate::drivers::arms
