// Several balls in the air at once, of one kind, that bounce off planes and off each other.
//
// Any inertial frame, SI. Pure functions on values; they allocate nothing and are safe from any thread.
// Impacts are taken in the order of time, balls against all others (n^2 / 2 pairs a step). Source:
// docs/theory/ball-flight.md: two thin shells, Coulomb friction up to grip.
#pragma once

#include <optional>
#include <span>

#include "palpate/physics/flight.h"

namespace palpate::physics {

// When two balls that fly for h touch first; nothing for balls that are parting. 0 for balls that overlap and
// approach.
std::optional<double> first_touch(const BallModel& model, const BallState& a, const BallState& b, double h);

// The impact of two equal balls that touch: their normal relative velocity becomes -e times itself, momentum
// and angular momentum are kept, friction takes what Coulomb allows up to 2/5 of their slip. Nothing happens
// to balls that are parting.
void collide(const BallModel& model, const Bounce& law, BallState& a, BallState& b);

// Flies all for dt >= 0 in steps of at most `max_step`; returns the number of impacts, of balls with planes
// and with each other. Balls that bounce more than 64
// times each, as those at rest do, lie where they are for the rest of dt.
int advance_all(const BallModel& model, std::span<const BouncePlane> planes, const Bounce& between,
                std::span<BallState> balls, double dt, double max_step = 0.005);

}  // namespace palpate::physics
