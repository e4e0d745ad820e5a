// Where a recorded ball was struck or bounced: moments at which its velocity jumps.
//
// Found without knowing where tables are: before and after each moment a flight is fitted that bends as it
// was seen to, whatever air and spin did, and the two are met where they come closest. The recording's frame,
// SI. Pure functions, thread-safe; they allocate.
#pragma once

#include <span>
#include <vector>

#include "palpate/physics/flight.h"

namespace palpate::physics {

struct VelocityJump {
  double time = 0.0;                 // s, as the recording counts
  Vector3 place = Vector3::Zero();   // of the ball's centre
  Vector3 before = Vector3::Zero();  // velocity, m/s
  Vector3 after = Vector3::Zero();
  double seen_s = 0.0;  // length of the shorter of the two flights fitted
  double gap = 0.0;  // m between the two flights where they come closest: large where one of them fits badly

  Vector3 change() const { return after - before; }
};

struct JumpSettings {
  double least_change = 1.5;      // m/s
  double least_deviations = 6.0;  // the same, in standard deviations as the scatter of the places has it
  double first_look_s = 0.080;    // length of the flights that show that there was a jump
  double fit_s = 0.200;           // at most, of the flights fitted before and after it
  std::size_t least_seen = 5;     // observations on either side
};

// In order of time. Jumps closer together than `first_look_s` count as one, the largest. Empty where there is
// none, or too little was seen.
std::vector<VelocityJump> find_velocity_jumps(const Vector3& gravity, std::span<const SeenBall> seen,
                                              const JumpSettings& settings = {});

// Whether a resting surface with normal `up` explains the jump: the ball came down and goes up, slower than
// it came, and was not dragged along by more than friction `mu` (with room for noise: ball on table 0.25, so
// 0.5).
bool bounced_on_resting_surface(const VelocityJump& jump, const Vector3& up, double mu = 0.5);

// -v_n' / v_n of such a bounce.
double restitution_of(const VelocityJump& jump, const Vector3& up);

}  // namespace palpate::physics
