#include "prodder.h"

#include <algorithm>

#include "application.h"

namespace jelly {
namespace {

using palpate::Point;
using palpate::Vector3;

constexpr double kHover_m = 0.020, kPress_m = 0.020;
constexpr double kSpeed = 0.20;  // m/s, mean, on the way to a place
constexpr double kDown_s = 0.5, kHold_s = 0.6, kUp_s = 0.15, kWatch_s = 0.5, kLeastWay_s = 0.4;
constexpr double kLevel = 0.75;     // least upward part of the surface's direction
constexpr std::size_t kTries = 50;  // once in seconds
constexpr double kLean = 0.9;       // rad: the stylus leans from the user up to the vertical by that much

}  // namespace

Prodder::Prodder(const palpate::scene::SceneDescription& scene, const palpate::scene::Reach& reach,
                 const palpate::scene::PlayerSettings& settings)
    : reach_(reach),
      settings_(settings),
      X_world_jelly_(place_on_table(scene)),
      random_(settings.seed, "jelly/prodder"),
      mould_(mould()),
      place_(mould_.vertices.front()),
      out_(Vector3::UnitY()),
      hand_(settings.hand, settings.max_acceleration, reach.home()) {
  go(0.0, reach.home(), 1.0);
}

Vector3 Prodder::above(double height) const {
  return (X_world_jelly_ * Point<JellyFrame>{place_ + (kTipRadius + height) * out_}).m;
}

// A place on top that the arm reaches, from over it to as deep as it is pressed; else the one before.
void Prodder::choose() {
  const Vector3 place = place_, out = out_;
  for (std::size_t i = 0; i < kTries; ++i) {
    const double any = random_.uniform(0.0, 1.0);
    place_ = mould_.vertices[std::min(kRim - 1, static_cast<std::size_t>(any * static_cast<double>(kRim)))];
    out_ = outward(place_);
    if (out_.y() > kLevel && reach_.contains(above(kHover_m)) && reach_.contains(above(-kPress_m))) return;
  }
  place_ = place;
  out_ = out;
}

void Prodder::go(double now, const Vector3& to, double duration) {
  const palpate::scene::HandState from{now > begin_ ? path_.at(now - begin_).position : to, Vector3::Zero(),
                                       Vector3::Zero()};
  path_ = palpate::scene::Quintic(from, {to, Vector3::Zero(), Vector3::Zero()}, duration);
  begin_ = now;
}

void Prodder::next(double now) {
  switch (doing_) {
    case Doing::watching:
      choose();
      doing_ = Doing::coming;
      go(now, above(kHover_m),
         std::max(kLeastWay_s, (above(kHover_m) - path_.at(now - begin_).position).norm() / kSpeed));
      break;
    case Doing::coming:
      doing_ = Doing::pressing;
      go(now, above(-kPress_m), kDown_s);
      break;
    case Doing::pressing:
      doing_ = Doing::holding;
      go(now, above(-kPress_m), kHold_s);
      break;
    case Doing::holding:
      doing_ = Doing::letting_go;
      go(now, above(kHover_m), kUp_s);
      break;
    case Doing::letting_go:
      doing_ = Doing::watching;
      go(now, above(kHover_m), kWatch_s);
      break;
  }
}

void Prodder::take_over(const palpate::device::HandTarget& at, palpate::Instant<palpate::PhysicsClock> now) {
  hand_ = palpate::scene::HandTrajectory(settings_.hand, settings_.max_acceleration, at.tip.m, at.velocity);
  path_ = palpate::scene::Quintic({at.tip.m, at.velocity, Vector3::Zero()},
                                  {reach_.home(), Vector3::Zero(), Vector3::Zero()},
                                  std::max(kLeastWay_s, (reach_.home() - at.tip.m).norm() / kSpeed));
  begin_ = now.seconds();
  doing_ = Doing::watching;
}

palpate::device::HandTarget Prodder::act(palpate::Instant<palpate::PhysicsClock> instant) {
  const double now = instant.seconds();
  if (begin_ == 0.0) begin_ = now;
  if (now - begin_ >= path_.duration()) next(now);
  const auto& target = hand_.follow(
      now, [this](double t) { return path_.at(t - begin_); },
      [this](double t) { return path_.jerk(t - begin_); });
  return {{target.position},
          target.velocity,
          X_world_jelly_.rotation * palpate::Quaternion(Eigen::AngleAxisd(-kLean, Vector3::UnitX()))};
}

}  // namespace jelly
