#include "palpate/sim/simulated_hand.h"

#include <algorithm>
#include <cmath>

namespace palpate::sim {
namespace {
constexpr double kBrake = 0.7;  // share of the acceleration planned for stopping
}  // namespace

void SimulatedHand::take(Grip grip, const Vector3& place, const Vector3& velocity) {
  if (grip_ == Grip::none || grip_ == Grip::swing || grip == Grip::none) {
    place_ = place;
    velocity_ = velocity;
    acceleration_.setZero();
    target_place_ = place;
    target_velocity_.setZero();
  }
  grip_ = grip;
  pull_.setZero();
}

void SimulatedHand::step(double h) {
  if (grip_ != Grip::follow) return;
  const Vector3 error = target_place_ - place_;
  const double distance = error.norm();
  // Close by the wanted speed falls with the distance; farther out it is the speed from which the hand can
  // still stop.
  const double brake = kBrake * settings_.max_acceleration;
  const double linear = brake / (kApproachRate * kApproachRate);
  const double speed =
      distance <= linear ? kApproachRate * distance : std::sqrt(brake * (2.0 * distance - linear));
  Vector3 wanted = target_velocity_;
  if (distance > 1e-12) wanted += error * (std::min(speed, settings_.max_speed) / distance);
  acceleration_ = kSpeedRate * (wanted - velocity_);
  const double size = acceleration_.norm();
  if (size > settings_.max_acceleration) acceleration_ *= settings_.max_acceleration / size;
  velocity_ += h * acceleration_;
  place_ += h * velocity_;
}

SimulatedHand::Push SimulatedHand::push(const Vector3& place, double mass) const {
  switch (grip_) {
    case Grip::none:
      return {};
    case Grip::swing:
      return {pull_, 0.0, settings_.damping};
    case Grip::follow:
      break;
  }
  return {mass * acceleration_ + settings_.stiffness * (place_ - place) + settings_.damping * velocity_,
          settings_.stiffness, settings_.damping};
}

}  // namespace palpate::sim
