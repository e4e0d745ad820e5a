// Plays impacts into the force of each haptic tick, by time, without looking at the hand: an open loop cannot
// go unstable.
//
// An impact takes the course of the contact model that its event names, with the event's own restitution and
// duration. Each tick gets the mean force over its span, so that the impulse is m (1 + e) v however the ticks
// fall. Impacts may overlap: their forces add. Haptic thread alone; no allocation, lock or exception after
// construction.
#pragma once

#include <array>
#include <optional>

#include "palpate/physics/contact_course.h"
#include "palpate/scene/application.h"

namespace palpate::haptics {

class ImpactRenderer {
 public:
  // Begins an impact: at its own start, or at `now` where that has passed. False where the numbers make no
  // impact (it is then ignored) or too many are under way.
  bool start(const scene::ImpactEvent& event, Instant<PhysicsClock> now);
  // An impact that comes too late to be felt: counts as requested, and is not played. False where it makes no
  // impact.
  bool skip(const scene::ImpactEvent& event, Instant<PhysicsClock> now);
  // Ends those under way; what they still had to give is not given. How many there were.
  int drop();
  // Mean force on the hand over [now, now + period], World, N; spans that a late tick left out come with this
  // one.
  Vector3 tick(Instant<PhysicsClock> now, Duration period);
  bool active() const;
  // Impulse that the impacts under way will still give after the last tick, N s.
  Vector3 to_come() const;
  // Impulse of all impacts started so far, as requested by their events, N s.
  const Vector3& requested() const { return requested_; }

 private:
  struct Impact {
    physics::ContactCourse course;
    Vector3 direction;
    Instant<PhysicsClock> start;
    double played = 0.0;  // s of the contact already handed out
  };
  std::array<std::optional<Impact>, 4> impacts_;
  Vector3 requested_ = Vector3::Zero();
};

}  // namespace palpate::haptics
