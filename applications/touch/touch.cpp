#include "applications/touch/touch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "applications/touch/organ.h"

namespace palpate::applications::touch {
namespace {

const Settings& checked_settings(const Settings& s) {
  if (!(s.sway_hz >= 0.0 && s.sway_hz <= 5.0) || !(std::abs(s.sway_m) <= 0.05) ||
      !(std::abs(s.sway_rad) <= 0.5))
    throw std::invalid_argument(
        fmt::format("touch: a sway of {} Hz, {} m, {} rad; at most 5 Hz, 0.05 m, 0.5 rad is expected",
                    s.sway_hz, s.sway_m, s.sway_rad));
  return s;
}

}  // namespace

TouchApplication::TouchApplication(const scene::SceneDescription& scene, const Settings& settings)
    : scene_(scene),
      settings_(checked_settings(settings)),
      surface_(touched_mesh(scene)),
      X_world_rest_(resting_place(scene, surface_)),
      X_world_organ_(X_world_rest_),
      law_(surface_settings(scene), surface_, settings.tip_radius, X_world_rest_) {}

void TouchApplication::reset() {
  ++resets_;
  counters_.fill(0);
}

void TouchApplication::move_organ(double dt) {
  const Pose<World, Organ> before = X_world_organ_;
  if (swaying_)
    phase_ = std::fmod(phase_ + 2.0 * std::numbers::pi * settings_.sway_hz * dt, 2.0 * std::numbers::pi);
  const Vector3 up = X_world_rest_.rotation * Vector3::UnitY();
  X_world_organ_.translation =
      X_world_rest_.translation + 0.5 * settings_.sway_m * (1.0 - std::cos(phase_)) * up;
  X_world_organ_.rotation =
      (so3_exp(settings_.sway_rad * std::sin(phase_) * up) * X_world_rest_.rotation).normalized();
  velocity_ = (X_world_organ_.translation - before.translation) / dt;
  spin_ = so3_log(X_world_organ_.rotation * before.rotation.conjugate()) / dt;
}

// Counts that have not followed the newest reset yet are 0.
void TouchApplication::count(const Touching& found) {
  const bool touching = found.engaged && found.proxy.touching;
  const bool follows = found.resets == resets_;
  const auto milli = [](double value) { return static_cast<std::int32_t>(std::min(1e9, 1e3 * value)); };
  counters_[kTouches] = follows ? found.touches : 0;
  counters_[kSlips] = follows ? found.slips : 0;
  counters_[kUnsettled] = follows ? found.unsettled : 0;
  counters_[kContactMs] = follows ? milli(found.contact_s) : 0;
  counters_[kPeakForceMn] = follows ? milli(found.peak_n) : 0;
  counters_[kForceMn] = milli(found.force.norm());
  counters_[kSliding] = touching && found.proxy.sliding;
  counters_[kDepthUm] = touching ? static_cast<std::int32_t>(std::min(1e9, 1e6 * found.proxy.depth)) : 0;
}

void TouchApplication::show(const scene::TipState& tip, double dt, scene::SceneState& state) {
  const bool touching = shown_.engaged && shown_.proxy.touching;
  const Vector3& place = tip.X_world_tip.translation;
  const bool seen = place.allFinite() && tip.velocity.allFinite();
  state.body_count = 3;
  auto& organ = state.bodies[kOrgan];
  organ.set_p(X_world_organ_.translation);
  organ.set_q(X_world_organ_.rotation);
  organ.set_v(velocity_);
  organ.set_w(spin_);
  auto& stylus = state.bodies[kStylus];
  stylus.visible = seen;
  auto& ball = state.bodies[kProxy];
  ball.visible = shown_.engaged;
  if (seen) {
    const Vector3 lever = tip.X_world_tip.rotation * scene_.carried_offset;
    stylus.set_p(place + lever);
    stylus.set_q(tip.X_world_tip.rotation);
    stylus.set_v(tip.velocity + tip.angular_velocity.cross(lever));
    stylus.set_w(tip.angular_velocity);
  }
  if (shown_.engaged) {
    const Vector3 before = ball.p();
    // While it is free it is where the tip is, which may have moved since the haptic tick.
    const Vector3 since = touching || !seen ? Vector3(Vector3::Zero()) : Vector3(place - shown_.tip);
    ball.set_p((X_world_organ_ * Point<Organ>{shown_.proxy.position}).m + since);
    ball.set_q(stylus.q());
    ball.set_v(!touching ? tip.velocity : dt > 0.0 ? Vector3((ball.p() - before) / dt) : Vector3::Zero());
  }
  ball.jumps = shown_.jumps;  // no path is drawn across these
}

void TouchApplication::step(Instant<PhysicsClock> now, Duration dt, const scene::TipState& tip,
                            scene::SceneState& state) {
  const double h = to_seconds(dt);
  if (h > 0.0) move_organ(h);
  law_.move_organ({now, X_world_organ_, velocity_, spin_, paused(), resets_});
  shown_ = law_.newest();
  if (paused()) shown_.force.setZero();
  count(shown_);
  show(tip, h, state);
  state.counters = counters_;
  const Vector3& force = shown_.force;
  const bool touching = shown_.engaged && shown_.proxy.touching;
  state.continuous.force = {force.x(), force.y(), force.z()};
  state.continuous.touching = touching ? 1 : 0;
  if (touching) {
    const Vector3 foot = shown_.proxy.position - settings_.tip_radius * shown_.proxy.normal;
    const Vector3 point = (X_world_organ_ * Point<Organ>{foot}).m;
    state.continuous.point = {point.x(), point.y(), point.z()};
  }
}

}  // namespace palpate::applications::touch
