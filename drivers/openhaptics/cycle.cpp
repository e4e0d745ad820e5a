// The two fast loops' side: the library's cycle, and what the haptic loop takes from it and leaves for it.
// Neither locks, allocates, throws or writes text.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/openhaptics/connection.h"
#include "drivers/openhaptics/error_text.h"
#include "palpate/core/units.h"

namespace palpate::drivers::openhaptics {
namespace {

// Beyond this turn the side the tip is on is told by more than noise.
constexpr double kClearTurn = 0.05;         // rad
constexpr unsigned kCalibrationEvery = 64;  // cycles
constexpr int kMostErrors = 16;             // taken from the library's list at a time

Vector3 vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

}  // namespace

device::ArmSample OpenHapticsArm::Connection::read() const {
  device::ArmSample sample;
  SampleWire wire;
  const bool any = samples_.read(wire);
  sample.stamp = {Duration(any ? wire.stamp_ns : now_ns())};
  const bool fresh = any && !lost_.load(std::memory_order_acquire) &&
                     wire.stamp_ns >= connected_ns_.load(std::memory_order_relaxed) &&
                     to_seconds(Duration(now_ns() - wire.stamp_ns)) <= settings_.watchdog_s;
  if (fresh) {
    sample.joints = {wire.joints[0], wire.joints[1], wire.joints[2]};
    sample.gimbal = {wire.gimbal[0], wire.gimbal[1], wire.gimbal[2]};
    sample.buttons = wire.buttons;
  } else {
    sample.joints.setConstant(std::numeric_limits<double>::quiet_NaN());
    sample.gimbal = sample.joints;
  }
  sample.waited = std::max(Duration(0), Duration(now_ns() - sample.stamp.ns()));
  sample.connected = !lost_.load(std::memory_order_acquire);
  sample.withheld = withheld(sample.connected);
  GivenWire given;
  sample.held = sample.connected && givens_.read(given) ? vector(given.force) : Vector3(Vector3::Zero());
  return sample;
}

// Both impulses are carried on to now, so that a force that is held adds nothing to the difference. Of a
// device that is gone nothing more is known to be given.
Vector3 OpenHapticsArm::Connection::withheld(bool connected) const {
  if (commanded_ns_ == 0) return Vector3::Zero();
  const std::int64_t now = now_ns();
  Vector3 given = Vector3::Zero();
  if (GivenWire wire; givens_.read(wire)) {
    given = vector(wire.impulse);
    if (connected) given += to_seconds(Duration(now - wire.stamp_ns)) * vector(wire.force);
  }
  return commanded_impulse_ + to_seconds(Duration(now - commanded_ns_)) * commanded_ - given;
}

void OpenHapticsArm::Connection::command(const Vector3& force) {
  const bool usable = force.allFinite();
  if (!usable) refused_commands_.fetch_add(1, std::memory_order_relaxed);
  const Vector3 kept = usable ? force : Vector3(Vector3::Zero());
  const std::int64_t now = now_ns();
  if (commanded_ns_ != 0) commanded_impulse_ += to_seconds(Duration(now - commanded_ns_)) * commanded_;
  commanded_ = kept;
  commanded_ns_ = now;
  commands_.write({now, {kept.x(), kept.y(), kept.z()}});
}

unsigned int OpenHapticsArm::Connection::cycle() noexcept {
  inside_.store(true);
  const bool last = closing_.load();
  hd_.begin_frame(handle_);
  const std::int64_t now = now_ns();
  Vector3 psi = Vector3::Zero();
  std::array<double, 16> transform{};
  hd_.get_doublev(hd::kJointAngles, psi.data());
  hd_.get_doublev(hd::kTransform, transform.data());
  int buttons = 0;
  hd_.get_integerv(hd::kCurrentButtons, &buttons);
  look_at_calibration();
  const bool calibrated = calibration_.load() == hd::kCalibrationOk;
  std::optional<SampleWire> sample =
      calibrated ? sample_from(psi, Eigen::Map<const Eigen::Matrix4d>(transform.data()), now) : std::nullopt;

  if (sample) sample->buttons = static_cast<std::uint32_t>(buttons);

  const Vector3 force = last ? Vector3(Vector3::Zero()) : force_now(now, sample.has_value());
  hd_.set_doublev(hd::kForce, force.data());
  hd_.end_frame(handle_);
  given_.store(force.norm());
  if (last_cycle_ns_ != 0) given_impulse_ += to_seconds(Duration(now - last_cycle_ns_)) * held_;
  last_cycle_ns_ = now;

  const std::uint64_t refused_before = force_errors_.load(std::memory_order_relaxed);
  const bool usable = look_at_errors(now);
  // A force the device complains of it does not give.
  const bool taken = usable && force_errors_.load(std::memory_order_relaxed) == refused_before;
  held_ = taken ? force : Vector3(Vector3::Zero());
  givens_.write(
      {now, {given_impulse_.x(), given_impulse_.y(), given_impulse_.z()}, {held_.x(), held_.y(), held_.z()}});
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
void OpenHapticsArm::Connection::look_at_calibration() noexcept {
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
std::optional<OpenHapticsArm::Connection::SampleWire> OpenHapticsArm::Connection::sample_from(
    Vector3 psi, const Eigen::Matrix4d& pose_mm, std::int64_t now) noexcept {
  const Matrix3 R = pose_mm.topLeftCorner<3, 3>();
  const Vector3 place = pose_mm.topRightCorner<3, 1>() / kMillimetresPerMetre;
  constexpr double kRotationTolerance = 1e-3;  // the library computes in single precision
  if (!psi.allFinite() || !pose_mm.allFinite() ||
      (R * R.transpose() - Matrix3::Identity()).cwiseAbs().maxCoeff() > kRotationTolerance ||
      R.determinant() < 0.0)
    return std::nullopt;
  if (turret_ == 0.0 && std::abs(psi[0]) > kClearTurn) turret_ = psi[0] * place.x() < 0.0 ? -1.0 : 1.0;
  psi[0] *= turret_ != 0.0 ? turret_ : (psi[0] * place.x() < 0.0 ? -1.0 : 1.0);

  const Vector3 between = device::phantom_tip(psi, settings_.lengths).m - place;
  if (!between_at_start_) between_at_start_ = between;
  if ((between - *between_at_start_).norm() > kLargestMismatch) inconsistent_.store(true);

  const Vector3 gimbal = device::phantom_gimbal(psi, Quaternion(R).normalized());
  SampleWire wire;
  wire.stamp_ns = now;
  wire.joints = {psi[0], psi[1], psi[2]};
  wire.gimbal = {gimbal[0], gimbal[1], gimbal[2]};
  return wire;
}

bool OpenHapticsArm::Connection::holds() const {
  return force_error_.load() != hd::kSuccess &&
         to_seconds(Duration(now_ns() - force_error_ns_.load())) < settings_.hold_s;
}

// Nothing without a sample of this cycle, which says where the force would go.
Vector3 OpenHapticsArm::Connection::force_now(std::int64_t now, bool sampled) noexcept {
  const auto since = [now](std::int64_t then) { return to_seconds(Duration(now - then)); };
  CommandWire wire;
  const bool any = commands_.read(wire);
  const bool stale = any && since(wire.sent_ns) > settings_.watchdog_s;
  if (stale) stale_cycles_.fetch_add(1, std::memory_order_relaxed);
  if (!any || inconsistent_.load() || holds()) {
    strength_.restart();
    return Vector3::Zero();
  }
  const double age = std::max(since(wire.sent_ns), sampled ? 0.0 : since(last_sample_ns_));
  const bool released = wire.sent_ns <= let_go_ns_.load();
  strength_.tick(!stale && !released && sampled, age, last_cycle_ns_ == 0 ? 0.0 : since(last_cycle_ns_));
  if (sampled) last_sample_ns_ = now;
  if (!sampled || released) strength_.let_go();
  Vector3 force = strength_.gain() * vector(wire.force);
  const double norm = force.norm();
  if (norm > facts_.peak_n) force *= facts_.peak_n / norm;
  return force;
}

// False where the device is lost.
bool OpenHapticsArm::Connection::look_at_errors(std::int64_t now) noexcept {
  for (int i = 0; i < kMostErrors; ++i) {
    const hd::ErrorInfo error = hd_.get_error();
    const ErrorKind kind = error_text(error.code).kind;
    if (kind == ErrorKind::none) break;
    if (kind == ErrorKind::device) {
      fatal_internal_.store(error.internal);
      fatal_.store(error.code);
      lost_.store(true, std::memory_order_release);
      return false;
    }
    strength_.restart();
    force_error_internal_.store(error.internal);
    force_error_.store(error.code);
    force_error_ns_.store(now);
    force_errors_.fetch_add(1, std::memory_order_relaxed);
  }
  return true;
}

}  // namespace palpate::drivers::openhaptics
