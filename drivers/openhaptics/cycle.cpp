// The library's cycle: it does not lock, allocate, throw or write text.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "drivers/openhaptics/connection.h"
#include "drivers/openhaptics/error_text.h"
#include "palpate/core/units.h"

namespace palpate::drivers::openhaptics {
namespace {

// Beyond this turn the side the tip is on is told by more than noise.
constexpr double kClearTurn = 0.05;         // rad
constexpr unsigned kCalibrationEvery = 64;  // cycles
constexpr int kMostErrors = 16;             // taken from the library's list at a time

}  // namespace

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
  std::optional<Reading> reading =
      calibrated ? reading_from(psi, Eigen::Map<const Eigen::Matrix4d>(transform.data()), now) : std::nullopt;

  if (reading) reading->buttons = static_cast<std::uint32_t>(buttons);

  const Vector3 force = last ? Vector3(Vector3::Zero()) : force_now(now, reading.has_value());
  hd_.set_doublev(hd::kForce, force.data());
  hd_.end_frame(handle_);
  given_.store(force.norm());

  const std::uint64_t refused_before = force_errors_.load(std::memory_order_relaxed);
  const bool usable = look_at_errors(now);
  // A force the device complains of it does not give.
  const bool taken = usable && force_errors_.load(std::memory_order_relaxed) == refused_before;
  mailbox_.tell_held(now, force, taken ? force : Vector3(Vector3::Zero()));
  if (usable && first_cycle_) mailbox_.set_lost(false);  // until then what was said last holds
  first_cycle_ = first_cycle_ && !usable;
  if (usable && reading) mailbox_.put(*reading);
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
std::optional<Reading> OpenHapticsArm::Connection::reading_from(Vector3 psi, const Eigen::Matrix4d& pose_mm,
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

  const Vector3 between = device::phantom_tip(psi, settings_.lengths).m - place;
  if (!between_at_start_) between_at_start_ = between;
  if ((between - *between_at_start_).norm() > kLargestMismatch) inconsistent_.store(true);

  const Vector3 gimbal = device::phantom_gimbal(psi, Quaternion(R).normalized());
  Reading reading;
  reading.stamp_ns = now;
  reading.joints = {psi[0], psi[1], psi[2]};
  reading.gimbal = {gimbal[0], gimbal[1], gimbal[2]};
  return reading;
}

bool OpenHapticsArm::Connection::holds() const {
  return force_error_.load() != hd::kSuccess &&
         to_seconds(Duration(now_ns() - force_error_ns_.load())) < settings_.hold_s;
}

// Nothing without a reading of this cycle, which says where the force would go.
Vector3 OpenHapticsArm::Connection::force_now(std::int64_t now, bool sampled) noexcept {
  const bool allowed = !inconsistent_.load() && !holds();
  Vector3 force = mailbox_.force_now(now, allowed, sampled ? std::optional(now) : std::nullopt);
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
      mailbox_.set_lost(true);
      return false;
    }
    mailbox_.restart();
    force_error_internal_.store(error.internal);
    force_error_.store(error.code);
    force_error_ns_.store(now);
    force_errors_.fetch_add(1, std::memory_order_relaxed);
  }
  return true;
}

}  // namespace palpate::drivers::openhaptics
