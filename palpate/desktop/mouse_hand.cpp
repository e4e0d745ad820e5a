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
// Of a pointer's move: so much of the distance between pointer and tip, that a head has made, it takes back besides.
constexpr double kCatchUp = 0.3;
constexpr double kNearest_m = 0.05;  // before the camera: what is nearer has no sensible pixel
// Over a surface.
constexpr double kHover_m = 0.010, kHighest_m = 0.060, kNotch_m = 0.001;
constexpr double kLift_m = 0.090;      // by the right button
constexpr double kPressSpeed = 0.060;  // m/s: a press so slow that the tissue's viscosity is felt little
constexpr double kThere_m = 0.005,
                 kAway_m = 0.015;  // beside the goal: it may touch; it has to go over the surface
constexpr double kFar_m = 0.030,
                 kRisen_m = 0.020;  // to the side: over all of it; so far below that it may set off
constexpr double kArch = 0.5, kHighestArch_m = 0.080;  // higher by so much of the way that is left

}  // namespace

MouseHand::MouseHand(const device::CameraModel& camera, const MouseHandSettings& settings)
    : camera_(camera), settings_(settings), rolled_(kHover_m), height_(kHover_m), position_(settings.home) {}

void MouseHand::roll(double notches) {
  depth_ = std::clamp(depth_ + notches * settings_.notch, -settings_.farthest, settings_.farthest);
  if (settings_.surface)
    rolled_ = std::clamp(rolled_ + notches * kNotch_m, -settings_.surface->explored().deepest, kHighest_m);
}

void MouseHand::point(const device::Pixel& pixel) {
  if (!settings_.faces && X_world_camera_ && (!aim_ || !pointer_ || pixel != *pointer_))
    aim_at(aim_ && pointer_ ? followed(pixel) : pixel);
  pointer_ = pixel;
}

void MouseHand::see(const Pose<World, CameraOptical>& X_world_camera) {
  X_world_camera_ = X_world_camera;
  if (!settings_.faces && pointer_ && !aim_) aim_at(*pointer_);
}

Vector3 MouseHand::ray() const {
  if (aim_) return aim_->along;
  if (!X_world_camera_) return settings_.forward;
  const device::Pixel at = pointer_.value_or(device::Pixel(camera_.cx, camera_.cy));
  return X_world_camera_->rotation *
         Vector3((at.x() - camera_.cx) / camera_.fx, (at.y() - camera_.cy) / camera_.fy, 1.0).normalized();
}

void MouseHand::aim_at(const device::Pixel& pixel) {
  pointer_ = pixel;
  aim_.reset();  // so that ray() is this pixel's
  Aim aim{X_world_camera_->translation, ray(), {}};
  if (settings_.surface) aim.place = settings_.surface->under(aim.eye, aim.along);
  aim_ = aim;
}

// Where the pointer's ray ends in the world.
Vector3 MouseHand::pointed_at() const {
  if (aim_->place) return aim_->place->at;
  return on_plane(*aim_).value_or(aim_->eye + aim_->along);
}

// The pixel that the pointer now means: what it meant, seen as the camera stands now, and its own move.
device::Pixel MouseHand::followed(const device::Pixel& pixel) const {
  const Vector3 seen = (X_world_camera_->inverse() * Point<World>{pointed_at()}).m;
  if (seen.z() < kNearest_m) return pixel;
  const device::Pixel move = pixel - *pointer_, meant = camera_.project_undistorted(seen) + move;
  const device::Pixel apart = pixel - meant;
  if (apart.norm() < 1e-9) return pixel;
  return meant + std::min(1.0, kCatchUp * move.norm() / apart.norm()) * apart;
}

// None where the ray goes along the plane or away from it.
std::optional<Vector3> MouseHand::on_plane(const Aim& aim) const {
  const Vector3 rising =
      std::cos(settings_.lean) * settings_.up + std::sin(settings_.lean) * settings_.forward;
  const Vector3 normal = settings_.right.cross(rising), middle = middle_of_plane();
  const double towards = normal.dot(aim.along);
  if (std::abs(towards) < kFlattest) return std::nullopt;
  const double along = normal.dot(middle - aim.eye) / towards;
  if (along <= 0.0) return std::nullopt;
  const Vector3 goal = aim.eye + along * aim.along, away = goal - middle;
  return away.norm() > kFarthest_m ? Vector3(middle + kFarthest_m / away.norm() * away) : goal;
}

double MouseHand::wanted_height() const { return left_ ? -settings_.surface->explored().press : rolled_; }

// Of the carried body. On the way to another place it goes over what lies between, and touches only where it is
// to: as a hand that lifts the stylus, moves it and sets it down.
Vector3 MouseHand::over_surface(const PointedSurface::Place& place) const {
  const Vector3 lever = stylus_rotation(position_) * settings_.offset;
  const Vector3 touching = place.at + settings_.surface->explored().tip_radius * place.normal;
  const Vector3 from = position_ - lever - touching;
  const double aside = (from - from.dot(place.normal) * place.normal).norm();
  const double there = std::clamp((kAway_m - aside) / (kAway_m - kThere_m), 0.0, 1.0);
  const double height = height_ < kHover_m ? kHover_m + there * (height_ - kHover_m) : height_;
  const double lift = std::clamp(kArch * (aside - kAway_m), 0.0, kHighestArch_m) + (right_ ? kLift_m : 0.0);
  return over_all(touching + height * place.normal + lift * settings_.up, position_ - lever) + lever;
}

// The tip's goal; farther away to the side than kFar_m it goes up first, and then on above all of the surface.
Vector3 MouseHand::over_all(const Vector3& goal, const Vector3& tip) const {
  const Vector3& up = settings_.up;
  const Vector3 way = goal - tip, to_the_side = way - way.dot(up) * up;
  if (to_the_side.norm() < kFar_m) return goal;
  const double above = settings_.surface->highest() + settings_.surface->explored().tip_radius + kHover_m;
  const double still_to_rise = above - up.dot(tip);
  const double share = std::clamp((kRisen_m - still_to_rise) / (kRisen_m - kThere_m), 0.0, 1.0);
  return tip + share * to_the_side + std::max(way.dot(up), still_to_rise) * up;
}

Vector3 MouseHand::wanted() const {
  std::optional<Aim> aim = aim_;
  if (settings_.faces && pointer_ && X_world_camera_) aim = Aim{X_world_camera_->translation, ray(), {}};
  Vector3 goal = middle_of_plane();
  if (aim && aim->place)
    goal = over_surface(*aim->place);
  else if (aim)
    goal = on_plane(*aim).value_or(goal);
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
    Matrix3 R;  // stylus +z away from its tip: up, and towards the person by its lean
    R.col(2) = std::cos(settings_.stylus_lean) * up - std::sin(settings_.stylus_lean) * settings_.forward;
    R.col(0) = settings_.right;
    R.col(1) = Vector3(R.col(2)).cross(settings_.right);
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
  const bool turns = !settings_.surface;
  const double to_turn = turns ? settings_.twist * ((left_ ? 1.0 : 0.0) - (right_ ? 1.0 : 0.0)) : 0.0;
  const double from = std::max(last_.value_or(t), t - kLongest_s);
  if (settings_.surface)
    height_ += std::clamp(wanted_height() - height_, -kPressSpeed * (t - from), kPressSpeed * (t - from));
  const Vector3 goal = wanted();
  for (double at = from; at < t; at += kStep_s) {
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
