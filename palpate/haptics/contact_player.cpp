#include "palpate/haptics/contact_player.h"

#include <algorithm>
#include <cmath>

namespace palpate {

bool ContactPlayer::start(const ContactEvent& event, Instant<PhysicsClock> now) {
  const double duration = to_seconds(event.duration);
  // The hand feels design B (nothing sticks); below its limit of restitution only the shape changes, not the
  // impulse.
  constexpr double kLeastRestitution = 0.15;
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
    const double e = std::max(event.restitution, kLeastRestitution);
    const double speed = event.approach_speed * (1.0 + event.restitution) / (1.0 + e);
    slot.emplace(Blow{DampedContact(event.mass, e, duration, Release::where_force_is_zero), event.direction,
                      speed, std::max(event.start, now)});
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
    const double until = std::min(to_seconds(now + period - blow.start), blow.contact.duration());
    if (until <= blow.played) continue;
    const double impulse = blow.speed * blow.contact.mean_force(blow.played, until) * (until - blow.played);
    force += impulse / to_seconds(period) * blow.direction;
    blow.played = until;
    if (until >= blow.contact.duration()) slot.reset();
  }
  return force;
}

Vector3 ContactPlayer::to_come() const {
  Vector3 sum = Vector3::Zero();
  for (const auto& slot : blows_) {
    if (!slot) continue;
    const auto& c = slot->contact;
    sum += slot->speed * c.mass() * (c.velocity(slot->played) + c.restitution()) * slot->direction;
  }
  return sum;
}

bool ContactPlayer::active() const {
  return std::any_of(blows_.begin(), blows_.end(), [](const auto& blow) { return blow.has_value(); });
}

}  // namespace palpate
