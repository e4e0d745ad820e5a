// The ordinary threads' side: opening, watching, closing, telling.
#include "drivers/openhaptics/connection.h"

#include <chrono>

#include "drivers/openhaptics/opening.h"
#include "palpate/core/units.h"

#include <pthread.h>

namespace palpate::drivers::openhaptics {
namespace {

constexpr std::int64_t kSilentNs = 250'000'000;      // the library has stopped calling
constexpr std::int64_t kRetryNs = 1'000'000'000;     // between attempts to open again
constexpr std::int64_t kPatienceNs = 1'000'000'000;  // for a last cycle at closing
constexpr std::int64_t kFadeAtEndNs = 200'000'000;

}  // namespace

Expected<void> OpenHapticsArm::Connection::begin() {
  if (auto opened = connect(); !opened) return opened;
  const std::int64_t until = now_ns() + kPatienceNs;
  while (cycles_.load() == 0 && fatal_.load() == hd::kSuccess && now_ns() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  watcher_ = std::thread([this] { watch(); });
  return {};
}

bool OpenHapticsArm::Connection::end() {
  {
    const std::lock_guard lock(sleep_guard_);
    ending_ = true;
  }
  sleep_.notify_all();
  if (watcher_.joinable()) watcher_.join();
  if (!connected_) return true;
  // Nobody commands any more: the last force fades of its own.
  const std::int64_t until = now_ns() + kFadeAtEndNs;
  while (given_.load() > 0.0 && !mailbox_.is_lost() && now_ns() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return disconnect();
}

ArmStatus OpenHapticsArm::Connection::status() const {
  ArmStatus status;
  status.cycles = cycles_.load();
  status.force_errors = force_errors_.load();
  status.stale_cycles = mailbox_.stale_forces();
  status.refused_commands = mailbox_.refused_commands();
  status.times_lost = times_lost_.load();
  const std::string name = device_words(settings_.name);
  const auto force_error = force_error_.load();
  const auto is = [&](device::HealthCode code, std::string words) {
    status.health = {code, std::move(words), "arm openhaptics: works again"};
  };
  if (mailbox_.is_lost()) {
    const std::lock_guard lock(line_guard_);
    is(device::HealthCode::arm_lost,
       told_lost_ ? last_error_line_ : error_line(settings_.name, fatal_.load(), fatal_internal_.load()));
    status.health->end +=
        "; see that it still knows where it is, then `palpate status --reset` lets forces come back";
  } else if (inconsistent_.load()) {
    is(device::HealthCode::arm_inconsistent,
       fmt::format(
           "arm openhaptics: {}: its joint angles and its tip's place differ by more than {:.0f} mm of "
           "way: forces stay off; put the arm's link lengths into nominal_arm of the rig file, "
           "calibrate the device with the maker's setup program, start again",
           name, kLargestMismatch * kMillimetresPerMetre));
  } else if (calibration_.load() != hd::kCalibrationOk) {
    is(device::HealthCode::arm_uncalibrated,
       fmt::format("arm openhaptics: {}: {}", name, calibration_words()));
  } else if (force_error != hd::kSuccess && holds()) {
    is(device::HealthCode::arm_forces_off,
       error_line(settings_.name, force_error, force_error_internal_.load()));
  }
  return status;
}

void OpenHapticsArm::Connection::watch() {
  pthread_setname_np(pthread_self(), "palpate-hd");
  std::int64_t next_try = 0;
  while (!asked_to_end()) {
    if (connected_) {
      const auto fatal = fatal_.load();
      const bool silent = now_ns() - alive_ns_.load() > kSilentNs;
      if (fatal == hd::kSuccess && !silent && !told_lost_) continue;
      if (!told_lost_)
        tell_lost(fatal != hd::kSuccess
                      ? error_line(settings_.name, fatal, fatal_internal_.load())
                      : fmt::format(
                            "arm openhaptics: {}: the library has not run its cycle for {:.2f} s; see "
                            "to the device's cable and power, and start again if it stays so",
                            device_words(settings_.name), to_seconds(Duration(now_ns() - alive_ns_.load()))));
      if (inside_.load()) continue;  // the library does not come back from the device: wait until it does
      disconnect();
      next_try = now_ns() + kRetryNs;
    } else if (now_ns() >= next_try) {
      if (auto opened = connect(); !opened) tell_lost(opened.error().message);
      next_try = now_ns() + kRetryNs;
    }
  }
}

bool OpenHapticsArm::Connection::asked_to_end() {
  std::unique_lock lock(sleep_guard_);
  return sleep_.wait_for(lock, std::chrono::milliseconds(20), [this] { return ending_; });
}

void OpenHapticsArm::Connection::tell_lost(std::string line) {
  const std::lock_guard lock(line_guard_);
  last_error_line_ = std::move(line);
  if (!told_lost_) times_lost_.fetch_add(1);
  told_lost_ = true;
  mailbox_.set_lost(true);
}

Expected<void> OpenHapticsArm::Connection::connect() {
  const std::lock_guard lock(library_->calls());
  auto opened = open_device(*library_, settings_.name);
  if (!opened) return tl::unexpected(opened.error());
  handle_ = opened->handle;
  calibration_style_ = opened->calibration_style;
  // Its calibration and the check of its forces are the first one's.
  if (facts_known_ && (opened->facts.model != facts_.model || opened->facts.serial != facts_.serial)) {
    hd_.disable_device(opened->handle);
    return refused(
        "OpenHaptics: the arm that came back is {} {}, and was {} {}; plug that one in, or start the server "
        "anew",
        opened->facts.model, opened->facts.serial, facts_.model, facts_.serial);
  }
  if (!facts_known_) facts_ = std::move(opened->facts);  // others read it while a device returns
  facts_known_ = true;
  // Only what a person has just said: an arm that comes back may stand anywhere.
  reset_wanted_ = settings_.at_reset_position && times_lost_.load() == 0;
  calibration_.store(hd::kCalibrationNeedsManualInput);
  fatal_.store(hd::kSuccess);
  force_error_.store(hd::kSuccess);
  inconsistent_.store(false);
  between_at_start_.reset();
  turret_ = 0.0;
  given_.store(0.0);
  first_cycle_ = true;
  closing_.store(false);
  done_.store(false);
  mailbox_.start(now_ns());
  alive_ns_.store(now_ns());
  {
    const std::lock_guard line(line_guard_);
    told_lost_ = false;
  }
  connected_ = true;
  // Scheduled first: the scheduler then begins with a cycle that asks for no force.
  scheduled_ = hd_.schedule_asynchronous(&Connection::run_cycle, this, hd::kHighestPriority);
  library_->use_scheduler();
  return {};
}

// False where the library does not let go of the cycle.
bool OpenHapticsArm::Connection::disconnect() {
  closing_.store(true);  // the next cycle asks for no force and is the last
  const std::int64_t until = now_ns() + kPatienceNs;
  while (!done_.load() && now_ns() < until && (inside_.load() || now_ns() - alive_ns_.load() <= kSilentNs))
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  if (inside_.load() && !done_.load()) return false;
  const std::lock_guard lock(library_->calls());
  if (!done_.load()) hd_.unschedule(scheduled_);
  library_->release_scheduler();
  hd_.disable_device(handle_);
  take_errors(hd_);
  connected_ = false;
  return true;
}

std::string OpenHapticsArm::Connection::calibration_words() const {
  if (calibration_style_ == hd::kEncoderReset)
    return "its encoders have lost their zero; put the arm into its reset position, hold it there and start "
           "again with --arm-at-reset";
  if (calibration_style_ == hd::kInkwell)
    return "it has to be calibrated; put the stylus into the inkwell until this line is taken back";
  return "it calibrates itself; move the stylus slowly through its whole reach";
}

}  // namespace palpate::drivers::openhaptics
