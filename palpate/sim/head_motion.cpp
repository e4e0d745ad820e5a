#include "palpate/sim/head_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/units.h"
#include "palpate/math/looking.h"
#include "palpate/sim/internal/wave.h"

namespace palpate::sim {
namespace {

constexpr double kNeck = 0.12;  // m from the eye back to the axis about which the head turns

}  // namespace

HeadMotion::HeadMotion(const config::WorldFile& world, const Vector3& board)
    : eye_(world.head.eye),
      look_at_(world.head.look_at),
      board_(board),
      turn_(world.head.turn_peak / (2.0 * std::numbers::pi * world.head.turn_hz)),
      turn_hz_(world.head.turn_hz),
      shake_(world.head.shake),
      shake_hz_(world.head.shake_hz) {}

void HeadMotion::change(bool around, double t) {
  if (around == around_) return;
  share_at_change_ = share_around(t);
  around_ = around;
  changed_ = t;
}

double HeadMotion::OwnTime::rate(double t) const {
  return rate_before + (rate_after - rate_before) * std::clamp((t - since) / kRest, 0.0, 1.0);
}

double HeadMotion::OwnTime::at(double t) const {
  const double slowing = std::clamp(t - since, 0.0, kRest);
  return then + 0.5 * (rate_before + rate(t)) * slowing + rate_after * (t - since - slowing);
}

void HeadMotion::hold_still(bool still, double t) {
  const double rate = still ? 0.0 : 1.0;
  if ((own_time_ ? own_time_->rate_after : 1.0) == rate) return;
  const OwnTime next{t, own_time(t), own_time_ ? own_time_->rate(t) : 1.0, rate};
  own_time_before_ = own_time_;
  own_time_ = next;
}

// Moments just gone by may lie before the last change.
double HeadMotion::own_time(double t) const {
  if (own_time_ && t >= own_time_->since) return own_time_->at(t);
  return own_time_before_ ? own_time_before_->at(t) : t;
}

double HeadMotion::share_around(double t) const {
  const double s = std::clamp((t - changed_) / kChange, 0.0, 1.0);
  const double smooth = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
  return share_at_change_ + ((around_ ? 1.0 : 0.0) - share_at_change_) * smooth;
}

Pose<World, CameraOptical> HeadMotion::in_use(double true_time) const {
  const double t = own_time(true_time);
  const auto straight = looking(eye_, look_at_);
  const Vector3 ahead = straight.rotation * Vector3::UnitZ();
  const Quaternion turn(Eigen::AngleAxisd(turn_ * wave(turn_hz_, t), Vector3::UnitY()));
  const Quaternion shake =
      so3_exp({shake_ * wave(shake_hz_, t), 0.5 * shake_ * wave(0.83 * shake_hz_, t, 1.0),
               0.5 * shake_ * wave(0.71 * shake_hz_, t, 2.0)});
  const Vector3 neck = eye_ - kNeck * ahead;
  return {(turn * straight.rotation * shake).normalized(), neck + kNeck * (turn * ahead)};
}

Pose<World, CameraOptical> HeadMotion::around_board(double t) const {
  const Vector3 outward = (eye_ - board_).normalized();
  const double side = 0.45 * wave(0.23, t), rise = 0.30 * wave(0.31, t, 0.7);
  const Quaternion orbit = Quaternion(Eigen::AngleAxisd(side, Vector3::UnitY())) *
                           Quaternion(Eigen::AngleAxisd(rise, Vector3::UnitX()));
  const double distance = 0.55 + 0.08 * wave(0.19, t, 1.3);
  const auto at_board = looking(board_ + distance * (orbit * outward), board_);
  // The board wanders to every edge of the picture: a lens is known only where corners were seen.
  const Vector3 turn(0.20 * wave(0.41, t, 0.4), 0.26 * wave(0.37, t, 2.1), 0.55 * wave(0.29, t, 1.1));
  return {(at_board.rotation * so3_exp(turn)).normalized(), at_board.translation};
}

Pose<World, CameraOptical> HeadMotion::at(double t) const {
  const double share = share_around(t);
  if (share <= 0.0) return in_use(t);
  if (share >= 1.0) return around_board(t);
  return interpolate(in_use(t), around_board(t), share);
}

}  // namespace palpate::sim
