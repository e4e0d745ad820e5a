#include "palpate/haptics/impact_renderer.h"

#include <algorithm>
#include <cmath>

namespace palpate::haptics {
namespace {

// Below, a model has no course (contact.h, hunt_crossley.h): then that of this restitution is played, of a
// impact so much slower that the impulse is the same.
double least_restitution(scene::ContactModel model) {
  return model == scene::ContactModel::non_sticky ? 0.15 : 0.05;
}

physics::ContactCourse course_of(const scene::ImpactEvent& event) {
  const double e = std::max(event.restitution, least_restitution(event.model));
  const double speed = event.approach_speed * (1.0 + event.restitution) / (1.0 + e);
  const double duration = to_seconds(event.duration);
  if (event.model == scene::ContactModel::hunt_crossley)
    return physics::ContactCourse(physics::HuntCrossleyContact(event.mass, e, duration, speed));
  const physics::Release release = event.model == scene::ContactModel::paper
                                       ? physics::Release::where_rest_length_is_back
                                       : physics::Release::where_force_is_zero;
  return {physics::DampedContact(event.mass, e, duration, release), speed};
}

bool makes_an_impact(const scene::ImpactEvent& event, Instant<PhysicsClock> now) {
  const double duration = to_seconds(event.duration);
  // Far beyond anything that hits what a hand holds: such a number is a mistake, or would hold a place for
  // ever.
  constexpr double kMostMass = 100.0, kMostSpeed = 1000.0, kLongest = 1.0;  // kg, m/s, s
  return event.mass > 0.0 && event.mass < kMostMass && duration > 0.0 && duration < kLongest &&
         event.approach_speed > 0.0 && event.approach_speed < kMostSpeed && event.restitution >= 0.0 &&
         event.restitution <= 1.0 && std::abs(event.direction.norm() - 1.0) < 1e-6 &&
         event.start <= now + seconds(kLongest);
}

Vector3 impulse_of(const scene::ImpactEvent& event) { return event.impulse() * event.direction; }

}  // namespace

bool ImpactRenderer::start(const scene::ImpactEvent& event, Instant<PhysicsClock> now) {
  if (!makes_an_impact(event, now)) return false;
  for (auto& slot : impacts_) {
    if (slot) continue;
    slot.emplace(Impact{course_of(event), event.direction, std::max(event.start, now)});
    requested_ += impulse_of(event);
    return true;
  }
  return false;
}

bool ImpactRenderer::skip(const scene::ImpactEvent& event, Instant<PhysicsClock> now) {
  if (!makes_an_impact(event, now)) return false;
  requested_ += impulse_of(event);
  return true;
}

int ImpactRenderer::drop() {
  int dropped = 0;
  for (auto& slot : impacts_) {
    dropped += slot.has_value();
    slot.reset();
  }
  return dropped;
}

Vector3 ImpactRenderer::tick(Instant<PhysicsClock> now, Duration period) {
  Vector3 force = Vector3::Zero();
  for (auto& slot : impacts_) {
    if (!slot) continue;
    Impact& impact = *slot;
    const double until = std::min(to_seconds(now + period - impact.start), impact.course.duration());
    if (until <= impact.played) continue;
    force += impact.course.impulse(impact.played, until) / to_seconds(period) * impact.direction;
    impact.played = until;
    if (until >= impact.course.duration()) slot.reset();
  }
  return force;
}

Vector3 ImpactRenderer::to_come() const {
  Vector3 sum = Vector3::Zero();
  for (const auto& slot : impacts_) {
    if (!slot) continue;
    sum += slot->course.impulse(slot->played, slot->course.duration()) * slot->direction;
  }
  return sum;
}

bool ImpactRenderer::active() const {
  return std::any_of(impacts_.begin(), impacts_.end(), [](const auto& impact) { return impact.has_value(); });
}

}  // namespace palpate::haptics
