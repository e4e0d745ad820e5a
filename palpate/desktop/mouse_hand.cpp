#include "palpate/desktop/mouse_hand.h"

#include <algorithm>
#include <cmath>

namespace palpate::desktop {
namespace {

constexpr double kStep_s = 0.001, kLongest_s = 0.1;
// Critically damped, 4 kApproach = kHurry: smooths the mouse's steps and lags by 1 / kApproach.
constexpr double kApproach = 25.0;   // 1/s: the last centimetres of a way, per e-fold
constexpr double kHurry = 100.0;     // 1/s: how fast the speed becomes the wanted one
constexpr double kBrake = 0.7;       // share of the acceleration planned for stopping
constexpr double kTwistRate = 12.0;  // 1/s
constexpr double kFlattest = 0.05;   // a ray more level with the plane than this meets it nowhere sensible
constexpr double kFarthest_m = 2.0;  // from home: what the pointer means beyond is "that way"
constexpr int kHalvings = 12;        // of the way home to the first place within reach: below a millimetre

}  // namespace

MouseHand::MouseHand(const device::CameraModel& camera, const MouseHandSettings& settings)
    : camera_(camera), settings_(settings), position_(settings.home) {}

void MouseHand::roll(double notches) {
  depth_ = std::clamp(depth_ + notches * settings_.notch, -settings_.farthest, settings_.farthest);
}

Vector3 MouseHand::ray() const {
  if (!X_world_camera_) return settings_.forward;
  const device::Pixel at = pointer_.value_or(device::Pixel(camera_.cx, camera_.cy));
  return X_world_camera_->rotation *
         Vector3((at.x() - camera_.cx) / camera_.fx, (at.y() - camera_.cy) / camera_.fy, 1.0).normalized();
}

Vector3 MouseHand::wanted() const {
  const Vector3 middle = settings_.home + depth_ * settings_.wheel;
  Vector3 goal = middle;
  if (pointer_ && X_world_camera_) {
    const Vector3 along_pointer = ray();
    const Vector3 rising =
        std::cos(settings_.lean) * settings_.up + std::sin(settings_.lean) * settings_.forward;
    const Vector3 normal = settings_.right.cross(rising);
    const double towards = normal.dot(along_pointer);
    const Vector3& eye = X_world_camera_->translation;
    const double along = std::abs(towards) < kFlattest ? -1.0 : normal.dot(middle - eye) / towards;
    if (along > 0.0) {
      goal = eye + along * along_pointer;
      const Vector3 away = goal - middle;
      if (away.norm() > kFarthest_m) goal = middle + kFarthest_m / away.norm() * away;
    }
  }
  const auto within = [this](const Vector3& place) {
    return !settings_.reachable || settings_.reachable(place - stylus_rotation(place) * settings_.offset);
  };
  if (within(goal)) return goal;
  // Home is within reach; the wheel may have led the plane's middle out of it, so the way starts at home.
  Vector3 good = settings_.home, bad = goal;
  for (int i = 0; i < kHalvings; ++i) {
    const Vector3 half = 0.5 * (good + bad);
    (within(half) ? good : bad) = half;
  }
  return good;
}

Quaternion MouseHand::stylus_rotation(const Vector3& carried) const {
  const Vector3& up = settings_.up;
  if (!settings_.faces) {
    Matrix3 R;  // stylus +z away from its tip: up
    R.col(2) = up;
    R.col(0) = settings_.right;
    R.col(1) = up.cross(settings_.right);
    return Quaternion(Eigen::AngleAxisd(twist_, up)) * Quaternion(R);
  }
  Vector3 level = *settings_.faces - carried;
  level -= up.dot(level) * up;
  const Vector3 ahead = level.norm() > 1e-6 ? Vector3(level.normalized()) : settings_.forward;
  const Vector3 normal = Eigen::AngleAxisd(twist_, up) * (ahead + settings_.raised * up).normalized();
  Matrix3 R;  // +y out of the face; stylus +z, away from what it carries, as far down as the face allows
  R.col(1) = normal;
  R.col(2) = (-up + up.dot(normal) * normal).normalized();
  R.col(0) = Vector3(R.col(1)).cross(Vector3(R.col(2)));
  return Quaternion(R) * Quaternion(Eigen::AngleAxisd(settings_.handle_tilt, Vector3::UnitY()));
}

void MouseHand::take_over(const device::HandTarget& at, double t) {
  position_ = at.tip.m + at.R_world_tip * settings_.offset;
  velocity_ = at.velocity;
  left_over_ = at.R_world_tip * stylus_rotation(position_).conjugate();
  last_ = t;
}

device::HandTarget MouseHand::act(double t) {
  const double to_turn = settings_.twist * ((left_ ? 1.0 : 0.0) - (right_ ? 1.0 : 0.0));
  const Vector3 goal = wanted();
  for (double at = std::max(last_.value_or(t), t - kLongest_s); at < t; at += kStep_s) {
    const double h = std::min(kStep_s, t - at);
    // Close by the speed falls with the distance; farther out it is the speed from which a hand still stops.
    const Vector3 left = goal - position_;
    const double d = left.norm(), brake = kBrake * settings_.max_acceleration;
    const double linear = brake / (kApproach * kApproach);
    const double speed = d <= linear ? kApproach * d : std::sqrt(brake * (2.0 * d - linear));
    Vector3 a = -kHurry * velocity_;
    if (d > 1e-12) a += kHurry * std::min(speed, settings_.max_speed) / d * left;
    if (a.norm() > settings_.max_acceleration) a *= settings_.max_acceleration / a.norm();
    velocity_ += h * a;
    position_ += h * velocity_;
    twist_ += h * kTwistRate * (to_turn - twist_);
    left_over_ = left_over_.slerp(h * kTwistRate, Quaternion::Identity());
  }
  last_ = t;
  const Quaternion R = (left_over_ * stylus_rotation(position_)).normalized();
  return {{position_ - R * settings_.offset}, velocity_, R};
}

}  // namespace palpate::desktop
