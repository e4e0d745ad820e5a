// How a hand moves: quintic paths, and a target that follows them with bounded acceleration. Pure; SI.
#pragma once

#include <array>

#include "palpate/geometry/so3.h"

namespace palpate::pingpong {

struct HandState {
  Vector3 position = Vector3::Zero(), velocity = Vector3::Zero(), acceleration = Vector3::Zero();
};

// The path of degree five between two states (Flash and Hogan 1985: least jerk): position, velocity,
// acceleration meet.
class Quintic {
 public:
  Quintic() = default;
  Quintic(const HandState& from, const HandState& to, double duration);
  HandState at(double t) const;  // clamped to [0, duration]
  Vector3 jerk(double t) const;
  Vector3 snap(double t) const;
  double duration() const { return duration_; }
  double largest_speed() const;         // sampled
  double largest_acceleration() const;  // sampled

 private:
  std::array<Vector3, 6> c_{Vector3::Zero(), Vector3::Zero(), Vector3::Zero(),
                            Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  double duration_ = 0.0;
};

// Bat that sends a ball from v_in to v_out (World, m/s): unit face normal towards the ball's side and speed
// along it.
struct Stroke {
  Vector3 normal = Vector3::UnitZ();
  double speed = 0.0;
};

}  // namespace palpate::pingpong
