#include "palpate/drivers/openhaptics/arm.h"

#include <Eigen/LU>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <limits>
#include <optional>
#include <thread>

#include "palpate/core/broadcast_ring.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/drivers/openhaptics/error_words.h"
#include "palpate/drivers/openhaptics/library.h"
#include "palpate/time/clock.h"

#include <pthread.h>

namespace palpate::openhaptics {
namespace {

// Makers' link lengths differ by some millimetres between sources, which moves the tip by as much; a joint
// that counts the wrong way, or has slipped, soon moves it by far more.
constexpr double kLargestMismatch = 0.025;  // m
// Beyond this turn the side the tip is on is told by more than noise.
constexpr double kClearTurn = 0.05;                  // rad
constexpr std::int64_t kSilentNs = 250'000'000;      // the library has stopped calling
constexpr std::int64_t kRetryNs = 1'000'000'000;     // between attempts to open again
constexpr std::int64_t kPatienceNs = 1'000'000'000;  // for a last cycle at closing
constexpr std::int64_t kFadeAtEndNs = 200'000'000;
constexpr unsigned kCalibrationEvery = 64;  // cycles
constexpr int kMostErrors = 16;             // taken from the library's list at a time
constexpr double kLongestCycle = 0.010;     // s, that a ramp may count

std::int64_t now_ns() { return MonotonicClock<ArmClock>::monotonic_ns(); }

std::string device_words(const std::string& name) {
  return name.empty() ? "the default device" : fmt::format("device '{}'", excerpt(name));
}

std::string error_line(const std::string& name, hd::ErrorCode code, int internal) {
  const ErrorWords words = error_words(code);
  return fmt::format("arm openhaptics: {}: {} ({} 0x{:04x}, device's own code {}); {}", device_words(name),
                     words.reason, words.name, code, internal, words.remedy);
}

// Newest error of the list, which is empty afterwards.
hd::ErrorInfo take_errors(const hd::Functions& hd) {
  hd::ErrorInfo newest = hd.get_error();
  for (int i = 0; i < kMostErrors && newest.code != hd::kSuccess; ++i)
    if (hd.get_error().code == hd::kSuccess) break;
  return newest;
}

std::string text_or_none(const char* text) { return text == nullptr ? "" : excerpt(text); }

struct Opened {
  hd::Handle handle = hd::kInvalidHandle;
  hd::Enum calibration_style = 0;
  ArmFacts facts;
};

// Opens the device and asks who it is. Under the library's calls().
Expected<Opened> open_device(Library& library, const std::string& name) {
  const auto& hd = library.hd();
  Opened opened;
  hd::ErrorInfo error{};
  int input = 0, output = 0, style = 0;
  library.while_scheduler_rests([&] {
    take_errors(hd);  // of others
    opened.handle = hd.init_device(name.empty() ? nullptr : name.c_str());
    error = take_errors(hd);
    // A warm motor is no reason to stay closed.
    if (opened.handle == hd::kInvalidHandle || error_words(error.code).kind == ErrorKind::device) return;
    hd.make_current_device(opened.handle);
    hd.get_integerv(hd::kInputDof, &input);
    hd.get_integerv(hd::kOutputDof, &output);
    hd.get_integerv(hd::kCalibrationStyle, &style);
    hd.get_doublev(hd::kNominalMaxForce, &opened.facts.peak_n);
    hd.get_doublev(hd::kNominalMaxContinuousForce, &opened.facts.continuous_n);
    opened.facts.model = text_or_none(hd.get_string(hd::kModel));
    opened.facts.serial = text_or_none(hd.get_string(hd::kSerialNumber));
    opened.facts.driver = text_or_none(hd.get_string(hd::kDriverVersion));
    hd.enable(hd::kForceOutput);
    error = take_errors(hd);
  });
  if (opened.handle == hd::kInvalidHandle && error.code == hd::kSuccess)
    error.code = hd::kDeviceFault;  // some versions only say that there is no handle
  const auto refuse = [&](std::string message) -> tl::unexpected<Error> {
    if (opened.handle != hd::kInvalidHandle) hd.disable_device(opened.handle);
    return refused("{}", message);
  };
  if (error_words(error.code).kind == ErrorKind::device)
    return refuse(error_line(name, error.code, error.internal));
  if (input < 6 || output < 3)
    return refuse(fmt::format(
        "arm openhaptics: {}: measures {} directions and gives force in {}, 6 and 3 are expected; an arm "
        "whose gimbal has encoders is needed",
        device_words(name), input, output));
  if (!std::isfinite(opened.facts.peak_n) || opened.facts.peak_n <= 0.0)
    return refuse(fmt::format(
        "arm openhaptics: {}: states {} N as its peak force, more than 0 is expected; run the maker's setup "
        "program for this device",
        device_words(name), opened.facts.peak_n));
  opened.facts.name = name;
  opened.facts.library = library.facts().file;
  opened.facts.library_version = library.facts().version;
  const auto bits = static_cast<hd::Enum>(style);
  opened.calibration_style = (bits & hd::kAuto) != 0      ? hd::kAuto
                             : (bits & hd::kInkwell) != 0 ? hd::kInkwell
                                                          : hd::kEncoderReset;
  return opened;
}

}  // namespace

class OpenHapticsArm::Connection {
  struct SampleWire {
    std::int64_t stamp_ns = 0;
    std::array<double, 3> joints{}, gimbal{};
  };
  struct CommandWire {
    std::int64_t sent_ns = 0;
    std::array<double, 3> force{};
  };

 public:
  Connection(const ArmSettings& settings, std::shared_ptr<Library> library)
      : settings_(settings), library_(std::move(library)), hd_(library_->hd()) {}

  Expected<void> begin() {
    if (auto opened = connect(); !opened) return opened;
    const std::int64_t until = now_ns() + kPatienceNs;
    while (cycles_.load() == 0 && fatal_.load() == hd::kSuccess && now_ns() < until)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    watcher_ = std::thread([this] { watch(); });
    return {};
  }

  // False where the library holds the cycle's thread and will not let go: this object must then stay.
  bool end() {
    {
      const std::lock_guard lock(sleep_guard_);
      ending_ = true;
    }
    sleep_.notify_all();
    if (watcher_.joinable()) watcher_.join();
    if (!connected_) return true;
    // Nobody commands any more: the last force fades of its own.
    const std::int64_t until = now_ns() + kFadeAtEndNs;
    while (given_.load() > 0.0 && !lost_.load() && now_ns() < until)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return disconnect();
  }

  ArmSample read() const {
    ArmSample sample;
    SampleWire wire;
    const bool any = samples_.read(wire);
    sample.stamp = {Duration(any ? wire.stamp_ns : now_ns())};
    const bool fresh = any && !lost_.load(std::memory_order_acquire) &&
                       wire.stamp_ns >= connected_ns_.load(std::memory_order_relaxed) &&
                       to_seconds(Duration(now_ns() - wire.stamp_ns)) <= settings_.watchdog_s;
    if (fresh) {
      sample.joints = {wire.joints[0], wire.joints[1], wire.joints[2]};
      sample.gimbal = {wire.gimbal[0], wire.gimbal[1], wire.gimbal[2]};
    } else {
      sample.joints.setConstant(std::numeric_limits<double>::quiet_NaN());
      sample.gimbal = sample.joints;
    }
    return sample;
  }

  void command(const Vector3& force) {
    const bool usable = force.allFinite();
    if (!usable) refused_commands_.fetch_add(1, std::memory_order_relaxed);
    const Vector3 kept = usable ? force : Vector3(Vector3::Zero());
    commands_.write({now_ns(), {kept.x(), kept.y(), kept.z()}});
  }

  ArmStatus status() const {
    ArmStatus status;
    status.cycles = cycles_.load();
    status.force_errors = force_errors_.load();
    status.stale_cycles = stale_cycles_.load();
    status.refused_commands = refused_commands_.load();
    status.times_lost = times_lost_.load();
    const std::string device = device_words(settings_.name);
    const auto force_error = force_error_.load();
    if (lost_.load()) {
      const std::lock_guard lock(line_guard_);
      status.condition = ArmCondition::gone;
      status.message =
          told_lost_ ? last_error_line_ : error_line(settings_.name, fatal_.load(), fatal_internal_.load());
    } else if (inconsistent_.load()) {
      status.condition = ArmCondition::inconsistent;
      status.message = fmt::format(
          "arm openhaptics: {}: its joint angles and its tip's place differ by more than {:.0f} mm of way: "
          "forces stay off; put the arm's link lengths into nominal_arm of the rig file, calibrate the "
          "device "
          "with the maker's setup program, start again",
          device, kLargestMismatch * kMillimetresPerMetre);
    } else if (calibration_.load() != hd::kCalibrationOk) {
      status.condition = ArmCondition::uncalibrated;
      status.message = fmt::format("arm openhaptics: {}: {}", device, calibration_words());
    } else if (force_error != hd::kSuccess && holds()) {
      status.condition = ArmCondition::forces_off;
      status.message = error_line(settings_.name, force_error, force_error_internal_.load());
    } else {
      status.condition = ArmCondition::running;
    }
    return status;
  }

  const ArmFacts& facts() const { return facts_; }

 private:
  // --- the library's thread: no lock, no allocation, no exception
  static unsigned int cycle(void* connection) { return static_cast<Connection*>(connection)->cycle(); }

  unsigned int cycle() noexcept {
    inside_.store(true);
    const bool last = closing_.load();
    hd_.begin_frame(handle_);
    const std::int64_t now = now_ns();
    Vector3 psi = Vector3::Zero();
    std::array<double, 16> transform{};
    hd_.get_doublev(hd::kJointAngles, psi.data());
    hd_.get_doublev(hd::kTransform, transform.data());
    look_at_calibration();
    const bool calibrated = calibration_.load() == hd::kCalibrationOk;
    const std::optional<SampleWire> sample =
        calibrated ? sample_from(psi, Eigen::Map<const Eigen::Matrix4d>(transform.data()), now)
                   : std::nullopt;

    Vector3 force = last || !sample ? Vector3(Vector3::Zero()) : force_now(now);
    if (last || !sample) gain_ = 0.0;
    hd_.set_doublev(hd::kForce, force.data());
    hd_.end_frame(handle_);
    given_.store(force.norm());
    last_cycle_ns_ = now;

    const bool usable = look_at_errors(now);
    if (usable && first_cycle_) lost_.store(false);  // until then what was said last holds
    first_cycle_ = first_cycle_ && !usable;
    if (usable && sample) samples_.write(*sample);
    alive_ns_.store(now);
    cycles_.fetch_add(1);
    const bool done = last || !usable;
    if (done) done_.store(true);
    inside_.store(false);
    return done ? hd::kCallbackDone : hd::kCallbackContinue;
  }

  // Sets a device's zero only with the motors off, as the maker asks for.
  void look_at_calibration() noexcept {
    const bool waits_for_the_motors = calibration_.load() == hd::kCalibrationNeedsUpdate;
    if (!first_cycle_ && !waits_for_the_motors && cycles_.load() % kCalibrationEvery != 0) return;
    hd::Enum found = hd_.check_calibration();
    const bool by_word =
        found == hd::kCalibrationNeedsManualInput && reset_wanted_ && calibration_style_ == hd::kEncoderReset;
    if ((found == hd::kCalibrationNeedsUpdate && calibration_style_ != hd::kEncoderReset) || by_word) {
      if (given_.load() == 0.0) {
        hd_.update_calibration(calibration_style_);
        reset_wanted_ = false;
        found = hd_.check_calibration();
      }
    }
    calibration_.store(found);
  }

  // Nothing where the readings are not numbers, or no pose.
  std::optional<SampleWire> sample_from(Vector3 psi, const Eigen::Matrix4d& pose_mm,
                                        std::int64_t now) noexcept {
    const Matrix3 R = pose_mm.topLeftCorner<3, 3>();
    const Vector3 place = pose_mm.topRightCorner<3, 1>() / kMillimetresPerMetre;
    constexpr double kRotationTolerance = 1e-3;  // the library computes in single precision
    if (!psi.allFinite() || !pose_mm.allFinite() ||
        (R * R.transpose() - Matrix3::Identity()).cwiseAbs().maxCoeff() > kRotationTolerance ||
        R.determinant() < 0.0)
      return std::nullopt;
    if (turret_ == 0.0 && std::abs(psi[0]) > kClearTurn) turret_ = psi[0] * place.x() < 0.0 ? -1.0 : 1.0;
    psi[0] *= turret_ != 0.0 ? turret_ : (psi[0] * place.x() < 0.0 ? -1.0 : 1.0);

    const Vector3 between = phantom_tip(psi, settings_.lengths).m - place;
    if (!between_at_start_) between_at_start_ = between;
    if ((between - *between_at_start_).norm() > kLargestMismatch) inconsistent_.store(true);

    const Vector3 gimbal = phantom_gimbal(psi, Quaternion(R).normalized());
    SampleWire wire;
    wire.stamp_ns = now;
    wire.joints = {psi[0], psi[1], psi[2]};
    wire.gimbal = {gimbal[0], gimbal[1], gimbal[2]};
    return wire;
  }

  bool holds() const {
    return force_error_.load() != hd::kSuccess &&
           to_seconds(Duration(now_ns() - force_error_ns_.load())) < settings_.hold_s;
  }

  Vector3 force_now(std::int64_t now) noexcept {
    CommandWire wire;
    const bool any = commands_.read(wire);
    const bool stale = any && to_seconds(Duration(now - wire.sent_ns)) > settings_.watchdog_s;
    if (stale) stale_cycles_.fetch_add(1, std::memory_order_relaxed);
    const double elapsed =
        last_cycle_ns_ == 0 ? 0.0 : std::min(kLongestCycle, to_seconds(Duration(now - last_cycle_ns_)));
    if (!any || inconsistent_.load() || holds()) {
      gain_ = 0.0;
    } else if (stale) {
      gain_ = std::max(0.0, gain_ - elapsed / settings_.fade_s);
    } else {
      gain_ = std::min(1.0, gain_ + elapsed / settings_.ramp_s);
    }
    Vector3 force = gain_ * Vector3(wire.force[0], wire.force[1], wire.force[2]);
    const double norm = force.norm();
    if (norm > facts_.peak_n) force *= facts_.peak_n / norm;
    return force;
  }

  // False where the device is lost.
  bool look_at_errors(std::int64_t now) noexcept {
    for (int i = 0; i < kMostErrors; ++i) {
      const hd::ErrorInfo error = hd_.get_error();
      const ErrorKind kind = error_words(error.code).kind;
      if (kind == ErrorKind::none) break;
      if (kind == ErrorKind::device) {
        fatal_internal_.store(error.internal);
        fatal_.store(error.code);
        lost_.store(true, std::memory_order_release);
        return false;
      }
      gain_ = 0.0;
      force_error_internal_.store(error.internal);
      force_error_.store(error.code);
      force_error_ns_.store(now);
      force_errors_.fetch_add(1, std::memory_order_relaxed);
    }
    return true;
  }

  // --- the watching thread
  void watch() {
    pthread_setname_np(pthread_self(), "palpate-hd");
    std::int64_t next_try = 0;
    while (!asked_to_end()) {
      if (connected_) {
        const auto fatal = fatal_.load();
        const bool silent = now_ns() - alive_ns_.load() > kSilentNs;
        if (fatal == hd::kSuccess && !silent && !told_lost_) continue;
        if (!told_lost_)
          tell_lost(
              fatal != hd::kSuccess
                  ? error_line(settings_.name, fatal, fatal_internal_.load())
                  : fmt::format("arm openhaptics: {}: the library has not run its cycle for {:.2f} s; see "
                                "to the device's cable and power, and start again if it stays so",
                                device_words(settings_.name),
                                to_seconds(Duration(now_ns() - alive_ns_.load()))));
        if (inside_.load()) continue;  // the library does not come back from the device: wait until it does
        disconnect();
        next_try = now_ns() + kRetryNs;
      } else if (now_ns() >= next_try) {
        if (auto opened = connect(); !opened) tell_lost(opened.error().message);
        next_try = now_ns() + kRetryNs;
      }
    }
  }

  bool asked_to_end() {
    std::unique_lock lock(sleep_guard_);
    return sleep_.wait_for(lock, std::chrono::milliseconds(20), [this] { return ending_; });
  }

  void tell_lost(std::string line) {
    const std::lock_guard lock(line_guard_);
    last_error_line_ = std::move(line);
    if (!told_lost_) times_lost_.fetch_add(1);
    told_lost_ = true;
    lost_.store(true);
  }

  Expected<void> connect() {
    const std::lock_guard lock(library_->calls());
    auto opened = open_device(*library_, settings_.name);
    if (!opened) return tl::unexpected(opened.error());
    handle_ = opened->handle;
    calibration_style_ = opened->calibration_style;
    if (!facts_known_) facts_ = std::move(opened->facts);  // others read it while a device returns
    facts_known_ = true;
    // Only what a person has just said: an arm that comes back may stand anywhere.
    reset_wanted_ = settings_.at_reset_position && times_lost_.load() == 0;
    calibration_.store(hd::kCalibrationNeedsManualInput);
    fatal_.store(hd::kSuccess);
    force_error_.store(hd::kSuccess);
    inconsistent_.store(false);
    between_at_start_.reset();
    turret_ = gain_ = 0.0;
    given_.store(0.0);
    last_cycle_ns_ = 0;
    first_cycle_ = true;
    closing_.store(false);
    done_.store(false);
    connected_ns_.store(now_ns());  // samples from before are of another life
    alive_ns_.store(now_ns());
    {
      const std::lock_guard line(line_guard_);
      told_lost_ = false;
    }
    connected_ = true;
    // Scheduled first: the scheduler then begins with a cycle that asks for no force.
    scheduled_ = hd_.schedule_asynchronous(&Connection::cycle, this, hd::kHighestPriority);
    library_->use_scheduler();
    return {};
  }

  // False where the library does not let go of the cycle.
  bool disconnect() {
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

  std::string calibration_words() const {
    if (calibration_style_ == hd::kEncoderReset)
      return "its encoders have lost their zero; put the arm into its reset position, hold it there and "
             "start "
             "again with --arm-at-reset";
    if (calibration_style_ == hd::kInkwell)
      return "it has to be calibrated; put the stylus into the inkwell until this line is taken back";
    return "it calibrates itself; move the stylus slowly through its whole reach";
  }

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
  double gain_ = 0.0, turret_ = 0.0;  // turret_: 1, -1, or 0 while not known
  std::int64_t last_cycle_ns_ = 0;
  std::optional<Vector3> between_at_start_;
  bool reset_wanted_ = false, first_cycle_ = true;

  // Where threads meet.
  Mailbox<SampleWire> samples_;
  Mailbox<CommandWire> commands_;
  std::atomic<bool> inside_{false}, closing_{false}, done_{false}, lost_{false}, inconsistent_{false};
  std::atomic<hd::Enum> calibration_{hd::kCalibrationNeedsManualInput};
  std::atomic<hd::ErrorCode> fatal_{hd::kSuccess}, force_error_{hd::kSuccess};
  std::atomic<int> fatal_internal_{0}, force_error_internal_{0};
  std::atomic<double> given_{0.0};  // N, in the last cycle
  std::atomic<std::int64_t> alive_ns_{0}, connected_ns_{0}, force_error_ns_{0};
  std::atomic<std::uint64_t> cycles_{0}, force_errors_{0}, stale_cycles_{0}, refused_commands_{0},
      times_lost_{0};

  mutable std::mutex line_guard_;
  std::string last_error_line_;
  bool told_lost_ = false;
  std::mutex sleep_guard_;
  std::condition_variable sleep_;
  bool ending_ = false;
  std::thread watcher_;
};

Expected<std::unique_ptr<OpenHapticsArm>> OpenHapticsArm::open(const ArmSettings& settings) {
  auto library = Library::load(settings.library);
  if (!library) return tl::unexpected(library.error());
  auto connection = std::make_unique<Connection>(settings, std::move(*library));
  if (auto begun = connection->begin(); !begun) return tl::unexpected(begun.error());
  return std::unique_ptr<OpenHapticsArm>(new OpenHapticsArm(std::move(connection)));
}

OpenHapticsArm::OpenHapticsArm(std::unique_ptr<Connection> connection) : connection_(std::move(connection)) {}

OpenHapticsArm::~OpenHapticsArm() {
  // A cycle that the library holds still uses it.
  if (!connection_->end()) [[maybe_unused]]
    auto* left = connection_.release();
}

ArmSample OpenHapticsArm::read() { return connection_->read(); }
void OpenHapticsArm::command(const Vector3& force) { connection_->command(force); }
ArmStatus OpenHapticsArm::status() const { return connection_->status(); }
const ArmFacts& OpenHapticsArm::facts() const { return connection_->facts(); }

std::optional<std::string> device_asked_for(std::string_view text) {
  constexpr std::string_view kDriver = "openhaptics";
  if (text == kDriver) return "";
  if (text.size() > kDriver.size() + 1 && text.starts_with(kDriver) && text[kDriver.size()] == ':')
    return std::string(text.substr(kDriver.size() + 1));
  return std::nullopt;
}

Expected<ArmFacts> probe_arm(const ArmSettings& settings) {
  auto library = Library::load(settings.library);
  if (!library) return tl::unexpected(library.error());
  const std::lock_guard lock((*library)->calls());
  auto opened = open_device(**library, settings.name);
  if (!opened) return tl::unexpected(opened.error());
  (*library)->hd().disable_device(opened->handle);
  take_errors((*library)->hd());
  return opened->facts;
}

}  // namespace palpate::openhaptics
