#include "palpate/haptics/contact_player.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

// Below, a model has no course (contact.h, hunt_crossley.h): then that of this restitution is played, of a
// blow so much slower that the impulse is the same.
double least_restitution(ContactModel model) { return model == ContactModel::non_sticky ? 0.15 : 0.05; }

ContactCourse course_of(const ContactEvent& event) {
  const double e = std::max(event.restitution, least_restitution(event.model));
  const double speed = event.approach_speed * (1.0 + event.restitution) / (1.0 + e);
  const double duration = to_seconds(event.duration);
  if (event.model == ContactModel::hunt_crossley)
    return ContactCourse(HuntCrossleyContact(event.mass, e, duration, speed));
  const Release release =
      event.model == ContactModel::paper ? Release::where_rest_length_is_back : Release::where_force_is_zero;
  return {DampedContact(event.mass, e, duration, release), speed};
}

}  // namespace

bool ContactPlayer::start(const ContactEvent& event, Instant<PhysicsClock> now) {
  const double duration = to_seconds(event.duration);
  // Far beyond anything that hits a hand-held bat: such a number is a mistake, or would hold a place for
  // ever.
  constexpr double kMostMass = 100.0, kMostSpeed = 1000.0, kLongest = 1.0;  // kg, m/s, s
  if (!(event.mass > 0.0 && event.mass < kMostMass) || !(duration > 0.0 && duration < kLongest) ||
      !(event.approach_speed > 0.0 && event.approach_speed < kMostSpeed) ||
      !(event.restitution >= 0.0 && event.restitution <= 1.0) ||
      !(std::abs(event.direction.norm() - 1.0) < 1e-6) || event.start > now + seconds(kLongest)) {
    return false;
  }
  for (auto& slot : blows_) {
    if (slot) continue;
    slot.emplace(Blow{course_of(event), event.direction, std::max(event.start, now)});
    asked_ += event.mass * (1.0 + event.restitution) * event.approach_speed * event.direction;
    return true;
  }
  return false;
}

Vector3 ContactPlayer::tick(Instant<PhysicsClock> now, Duration period) {
  Vector3 force = Vector3::Zero();
  for (auto& slot : blows_) {
    if (!slot) continue;
    Blow& blow = *slot;
    const double until = std::min(to_seconds(now + period - blow.start), blow.course.duration());
    if (until <= blow.played) continue;
    force += blow.course.impulse(blow.played, until) / to_seconds(period) * blow.direction;
    blow.played = until;
    if (until >= blow.course.duration()) slot.reset();
  }
  return force;
}

Vector3 ContactPlayer::to_come() const {
  Vector3 sum = Vector3::Zero();
  for (const auto& slot : blows_) {
    if (!slot) continue;
    sum += slot->course.impulse(slot->played, slot->course.duration()) * slot->direction;
  }
  return sum;
}

bool ContactPlayer::active() const {
  return std::any_of(blows_.begin(), blows_.end(), [](const auto& blow) { return blow.has_value(); });
}

}  // namespace palpate
