// A ball's whole flight over flat surfaces, and the flight that fits what was seen of one.
//
// For prediction and analysis: surfaces are planes with optional rims, met by the ball's lowest point (no
// edges; the game itself uses sweep.h). Any inertial frame, SI. Pure, no allocation in advance();
// thread-safe.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/physics/ball.h"

namespace palpate::physics {

// A plane at which the ball bounces. `point` is where the ball's CENTRE is at contact.
struct BouncePlane {
  Vector3 point = Vector3::Zero();
  Vector3 normal = Vector3::UnitY();
  Bounce law;
  // Half sides of the rectangle around `point`; empty = everywhere.
  std::optional<std::array<Vector3, 2>> half_sides;

  bool covers(const Vector3& centre) const;
};

// A rectangle with corners in touching order (front = (c1 - c0) x (c3 - c0)) as a plane for a ball of this
// radius.
BouncePlane bounce_plane(const std::array<Vector3, 4>& corners, double radius, const Bounce& law);

struct PlaneHit {
  double after = 0.0;  // s
  const BouncePlane* plane = nullptr;
};
// The first plane that the ball reaches within h from above. The plane is one of `planes`.
std::optional<PlaneHit> first_plane_hit(const BallModel& model, std::span<const BouncePlane> planes,
                                        const BallState& ball, double h);
// Bounces a ball that is at this plane; one that rounding has put below is lifted onto it.
void bounce_at(const BallModel& model, const BouncePlane& plane, BallState& ball);

// Flies for dt >= 0, bouncing at the planes it reaches; steps of at most `max_step`. Returns the number of
// bounces.
int advance(const BallModel& model, std::span<const BouncePlane> planes, BallState& ball, double dt,
            double max_step = 0.005);

struct SeenBall {
  double time = 0.0;  // s, any origin
  Vector3 position = Vector3::Zero();
};

struct FlightFit {
  BallState state;    // at `time`
  double time = 0.0;  // of the first observation
  double rms = 0.0;   // m per component
  int iterations = 0;
};

// Position and velocity at the first observation that fit all of them best, through bounces (least squares;
// six unknowns, spin taken as given). Refuses fewer than three observations, times less than 1 us apart, and
// places that no ball flies through.
Expected<FlightFit> fit_flight(const BallModel& model, std::span<const BouncePlane> planes,
                               std::span<const SeenBall> seen, const Vector3& spin = Vector3::Zero());

// The same with the spin unknown, too (nine unknowns, at least six observations). A flight tells spin across
// its path by drag and lift, spin along it only by a bounce; what it does not tell stays near zero (expected:
// 150 rad/s per axis, beside places seen to 3 mm).
Expected<FlightFit> fit_flight_and_spin(const BallModel& model, std::span<const BouncePlane> planes,
                                        std::span<const SeenBall> seen);

}  // namespace palpate::physics
