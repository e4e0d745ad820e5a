// Plays blows into the force of each haptic tick, by time, without looking at the hand: an open loop cannot
// go unstable.
//
// A blow takes the course of the contact model that its event names, with the event's own restitution and
// duration. Each tick gets the mean force over its span, so that the impulse is m (1 + e) v however the ticks
// fall. Blows may overlap: their forces add. Haptic thread alone; no allocation, lock or exception after
// construction.
#pragma once

#include <array>
#include <optional>

#include "palpate/physics/contact_course.h"
#include "palpate/scene/application.h"

namespace palpate {

class ContactPlayer {
 public:
  // Begins a blow: at its own start, or at `now` where that has passed. False where the numbers make no blow
  // (it is then ignored) or too many are under way.
  bool start(const ContactEvent& event, Instant<PhysicsClock> now);
  // Mean force on the hand over [now, now + period], World, N; spans that a late tick left out come with this
  // one.
  Vector3 tick(Instant<PhysicsClock> now, Duration period);
  bool active() const;
  // Impulse that the blows under way will still give after the last tick, N s.
  Vector3 to_come() const;
  // Impulse of all blows started so far, as asked by their events, N s.
  const Vector3& asked() const { return asked_; }

 private:
  struct Blow {
    ContactCourse course;
    Vector3 direction;
    Instant<PhysicsClock> start;
    double played = 0.0;  // s of the contact already handed out
  };
  std::array<std::optional<Blow>, 4> blows_;
  Vector3 asked_ = Vector3::Zero();
};

}  // namespace palpate
