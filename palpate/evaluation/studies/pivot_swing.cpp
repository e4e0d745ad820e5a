#include <cmath>
#include <numbers>
#include <optional>

#include "palpate/calibration/absolute_orientation.h"
#include "palpate/core/units.h"
#include "palpate/evaluation/studies/internal/pivot_study.h"
#include "palpate/math/random_vector.h"
#include "palpate/sim/smooth_field.h"

namespace palpate::evaluation::studies {
namespace {

const double kCapAngle = radians_from_degrees(60.0);  // a cap of a quarter of the sphere's area
const double kRoll = radians_from_degrees(60.0);
constexpr double kArmGainError = 0.01, kArmNoise = 0.03e-3;  // m, per axis

Quaternion any_orientation(Random& random) {
  for (;;) {
    // One after the other: a call's arguments are drawn in an order that is the compiler's.
    const double d = random.normal(), c = random.normal(), b = random.normal(), a = random.normal();
    const Eigen::Vector4d q(a, b, c, d);
    if (q.norm() > 1e-3) return Quaternion(q[0], q[1], q[2], q[3]).normalized();
  }
}

// The marker's direction from the tip within the cap about +z.
Quaternion in_cap(const Vector3& towards_marker, Random& random) {
  const double tilt = std::acos(random.uniform(std::cos(kCapAngle), 1.0));
  const double around = random.uniform(0.0, 2.0 * std::numbers::pi), roll = random.uniform(-kRoll, kRoll);
  const Quaternion upright = rotation_between(towards_marker, Vector3::UnitZ());
  const Vector3 axis(std::cos(around), std::sin(around), 0.0);
  return (Quaternion(Eigen::AngleAxisd(tilt, axis)) * Quaternion(Eigen::AngleAxisd(roll, Vector3::UnitZ())) *
          upright)
      .normalized();
}

}  // namespace

double bias_share_of(const sim::config::WorldFile& world) {
  const double white = std::pow(world.tracker.white_rms, 2), bias = std::pow(world.tracker.bias_rms, 2);
  return white + bias > 0.0 ? bias / (white + bias) : 0.0;
}

SwingDraw::SwingDraw(const sim::config::WorldFile& world, const SwingSettings& settings, std::uint64_t seed)
    : model_(world.tip_marker.leds), tip_(world.tip_marker.tip) {
  Random poses(seed, "study/swing"), noise(seed, "study/led-noise"), motion(seed, "study/tip-motion"),
      arm(seed, "study/arm-reading");
  const Vector3 towards_marker = -tip_.normalized();
  const double white = std::sqrt((1.0 - settings.bias_share) / 3.0);
  const double bias = std::sqrt(settings.bias_share / 3.0);
  std::vector<sim::SmoothField> field;
  if (bias > 0.0)
    for (const char* purpose : {"study/bias-x", "study/bias-y", "study/bias-z"})
      field.emplace_back(seed, purpose, world.tracker.bias_correlation);
  R_world_arm_ = any_orientation(arm);
  for (int i = 0; i < settings.poses; ++i) {
    Look look;
    look.rotation =
        settings.coverage == Coverage::full_sphere ? any_orientation(poses) : in_cap(towards_marker, poses);
    if (settings.motion == TipMotion::random) {
      look.shift = normal3(motion, 1.0 / std::sqrt(3.0));
    } else {
      // A pull of 0.5 to 1.5 of its mean; sqrt(13/12) is the rms of that factor.
      look.shift = look.rotation * towards_marker * (motion.uniform(0.5, 1.5) / std::sqrt(13.0 / 12.0));
    }
    for (const auto& led : model_) {
      const Vector3 place = look.rotation * (led - tip_);
      Vector3 error = normal3(noise, white);
      for (std::size_t axis = 0; axis < field.size(); ++axis)
        error[static_cast<Eigen::Index>(axis)] += bias * field[axis].at(place);
      look.leds.push_back(error);
    }
    look.arm_noise = normal3(arm, kArmNoise);
    looks_.push_back(std::move(look));
  }
}

Swing SwingDraw::with(const SwingErrors& errors) const {
  Swing result;
  std::vector<Vector3> seen(model_.size());
  for (const auto& look : looks_) {
    calibration::PivotPose pose;
    const Vector3 displacement = errors.tip_rms * look.shift;
    const Vector3 origin = displacement - look.rotation * tip_;
    if (errors.led_rms > 0.0) {
      for (std::size_t k = 0; k < seen.size(); ++k)
        seen[k] = look.rotation * model_[k] + origin + errors.led_rms * look.leds[k];
      const auto fit = calibration::fit_rigid(model_, seen);
      pose.rotation = Quaternion(fit.rotation).normalized();
      pose.translation = fit.translation;
    } else {
      pose.rotation = look.rotation;
      pose.translation = origin;
    }
    pose.motion = R_world_arm_.conjugate() * ((1.0 + kArmGainError) * displacement) + look.arm_noise;
    result.poses.push_back(pose);
    result.mean_place += displacement / static_cast<double>(looks_.size());
  }
  return result;
}

}  // namespace palpate::evaluation::studies
