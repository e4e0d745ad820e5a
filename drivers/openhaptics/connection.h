// One device and the threads that meet at it: the maker's cycle, the haptic loop, and the watching thread.
//
// Which thread may call what stands with each part; they meet in mailboxes and atomics only. How it behaves:
// arm.h. ArmBase, SI; the library's millimetres end in cycle.cpp.
#pragma once

#include <array>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "drivers/arms/loop_mailbox.h"
#include "drivers/openhaptics/arm.h"
#include "drivers/openhaptics/library.h"

namespace palpate::drivers::openhaptics {

using arms::now_ns;
using arms::Reading;

class OpenHapticsArm::Connection {
 public:
  Connection(const ArmSettings& settings, std::shared_ptr<Library> library)
      : settings_(settings), library_(std::move(library)), hd_(library_->hd()), mailbox_(settings.loop) {}

  // --- an ordinary thread
  Expected<void> begin();
  // False where the library holds the cycle's thread and will not let go: this object must then stay.
  bool end();
  ArmStatus status() const;
  const ArmFacts& facts() const { return facts_; }

  // --- the haptic loop, and any thread: as the mailbox says
  arms::LoopMailbox& mailbox() { return mailbox_; }

 private:
  // Makers' link lengths differ by some millimetres between sources, which moves the tip by as much; a joint
  // that counts the wrong way, or has slipped, soon moves it by far more.
  static constexpr double kLargestMismatch = 0.025;  // m

  // --- the library's thread: no lock, no allocation, no exception
  static unsigned int run_cycle(void* connection) { return static_cast<Connection*>(connection)->cycle(); }
  unsigned int cycle() noexcept;
  void look_at_calibration() noexcept;
  std::optional<Reading> reading_from(Vector3 psi, const Eigen::Matrix4d& pose_mm, std::int64_t now) noexcept;
  Vector3 force_now(std::int64_t now, bool sampled) noexcept;
  bool look_at_errors(std::int64_t now) noexcept;  // false where the device is lost

  // --- the watching thread; begin() and end() before it starts and after it has ended
  void watch();
  bool asked_to_end();
  void tell_lost(std::string line);
  Expected<void> connect();
  bool disconnect();  // false where the library does not let go of the cycle

  // --- any thread
  bool holds() const;
  std::string calibration_words() const;

  const ArmSettings settings_;
  const std::shared_ptr<Library> library_;
  const hd::Functions& hd_;
  ArmFacts facts_;

  // Set by connect() while no cycle runs.
  hd::Handle handle_ = hd::kInvalidHandle;
  std::atomic<hd::Enum> calibration_style_{hd::kInkwell};
  hd::SchedulerHandle scheduled_ = 0;
  bool connected_ = false, facts_known_ = false;

  // The cycle's own; connect() sets them while no cycle runs.
  double turret_ = 0.0;  // 1, -1, or 0 while not known
  std::optional<Vector3> between_at_start_;
  bool reset_wanted_ = false, first_cycle_ = true;

  // Where threads meet.
  arms::LoopMailbox mailbox_;
  std::atomic<bool> inside_{false}, closing_{false}, done_{false}, inconsistent_{false};
  std::atomic<hd::Enum> calibration_{hd::kCalibrationNeedsManualInput};
  std::atomic<hd::ErrorCode> fatal_{hd::kSuccess}, force_error_{hd::kSuccess};
  std::atomic<int> fatal_internal_{0}, force_error_internal_{0};
  std::atomic<double> given_{0.0};  // N, in the last cycle
  std::atomic<std::int64_t> alive_ns_{0}, force_error_ns_{0};
  std::atomic<std::uint64_t> cycles_{0}, force_errors_{0}, times_lost_{0};

  mutable std::mutex line_guard_;
  std::string last_error_line_;
  bool told_lost_ = false;
  std::mutex sleep_guard_;
  std::condition_variable sleep_;
  bool ending_ = false;
  std::thread watcher_;
};

}  // namespace palpate::drivers::openhaptics
