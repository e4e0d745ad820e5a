#include "applications/touch/touch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "applications/touch/organ.h"

namespace palpate::applications::touch {
namespace {

constexpr double kTeleport_m = 0.05;  // a tip that moves further in one step was put there, not moved
constexpr double kDampFrom_m =
    0.0005;  // depth at which the damper has its full size: it begins without a jump

const scene::SceneDescription& checked_material(const scene::SceneDescription& scene) {
  const scene::TouchedSurface& m = scene.touched;
  if (!(m.stiffness > 0.0 && m.stiffness <= kMostStiffness))
    throw std::invalid_argument(
        fmt::format("touch: stiffness {} N/m; more than 0 and at most {:.0f} is expected, which such an arm "
                    "renders; choose a softer material",
                    m.stiffness, kMostStiffness));
  if (!(m.damping >= 0.0 && m.damping <= kMostDamping))
    throw std::invalid_argument(
        fmt::format("touch: damping {} N s/m; 0 to {:.0f} is expected", m.damping, kMostDamping));
  if (!(m.friction >= 0.0 && m.static_friction >= m.friction && m.static_friction <= 2.0))
    throw std::invalid_argument(
        fmt::format("touch: friction {} at rest and {} sliding; 0 to 2, and at rest no less than sliding, is "
                    "expected",
                    m.static_friction, m.friction));
  return scene;
}

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
    : scene_(checked_material(scene)),
      settings_(checked_settings(settings)),
      surface_(touched_mesh(scene)),
      mesh_(surface_),
      proxy_(mesh_, {.radius = settings.tip_radius,
                     .friction = scene.touched.friction,
                     .static_friction = scene.touched.static_friction}),
      X_world_rest_(resting_place(scene, surface_)),
      X_world_organ_(X_world_rest_) {}

void TouchApplication::reset() {
  counters_.fill(0);
  contact_s_ = 0.0;
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

// Looking away from the middle: nothing there, or a triangle seen from its outer side.
bool TouchApplication::outside(const Vector3& p) const {
  const Vector3 away = p.norm() > 0.0 ? Vector3(p.normalized()) : Vector3::UnitY();
  const auto seen = mesh_.ray(p, p + 2.0 * mesh_.extent() * away);
  if (!seen) return true;
  const auto& t = surface_.triangles[seen->triangle];
  const Vector3& a = surface_.vertices[t[0]];
  return (surface_.vertices[t[1]] - a).cross(surface_.vertices[t[2]] - a).dot(away) < 0.0;
}

// The virtual coupling, in the organ's frame: a spring between tip and proxy, and along the normal a damper,
// which never pulls the tip down.
Vector3 TouchApplication::pull(const Vector3& tip, const Vector3& velocity) const {
  const physics::ProxyState& s = proxy_.state();
  if (!s.touching) return Vector3::Zero();
  const double share = std::min(1.0, s.depth / kDampFrom_m);
  const double spring = scene_.touched.stiffness * s.normal.dot(s.position - tip);
  const double damper = std::max(-spring, -scene_.touched.damping * share * s.normal.dot(velocity));
  return scene_.touched.stiffness * (s.position - tip) + damper * s.normal;
}

void TouchApplication::step(Instant<PhysicsClock> /*now*/, Duration dt, const scene::TipState& tip,
                            scene::SceneState& state) {
  const double h = to_seconds(dt);
  if (h > 0.0) move_organ(h);
  const Vector3 place = tip.X_world_tip.translation;
  const bool seen = place.allFinite() && tip.velocity.allFinite();
  if (!seen || (place - tip_before_).norm() > kTeleport_m) engaged_ = false;
  if (seen) tip_before_ = place;

  // What the organ sees: its own motion is the tip's, the other way round.
  const auto X_organ_world = X_world_organ_.inverse();
  const Vector3 p = (X_organ_world * Point<World>{place}).m;
  const bool touched = engaged_ && proxy_.state().touching, slid = touched && proxy_.state().sliding;
  if (seen && !engaged_ && proxy_.clear_at(p) && outside(p)) {
    engaged_ = true;
    proxy_.begin(p);
  }
  Vector3 force = Vector3::Zero();
  if (engaged_) {
    const physics::ProxyState& proxy = proxy_.follow(p);
    counters_[kUnsettled] += !proxy.settled;
    const Vector3 lever = place - X_world_organ_.translation;
    const Vector3 relative = tip.velocity - velocity_ - spin_.cross(lever);
    force = X_world_organ_.rotation * pull(p, X_organ_world.rotation * relative);
    counters_[kTouches] += proxy.touching && !touched;
    contact_s_ += proxy.touching ? h : 0.0;
    counters_[kSlips] += touched && proxy.sliding && !slid;
  }
  const bool touching = engaged_ && proxy_.state().touching;
  counters_[kSliding] = touching && proxy_.state().sliding;
  counters_[kDepthUm] = touching ? static_cast<std::int32_t>(std::min(1e9, 1e6 * proxy_.state().depth)) : 0;
  if (paused()) force.setZero();
  counters_[kContactMs] = static_cast<std::int32_t>(std::min(1e9, 1e3 * contact_s_));
  counters_[kForceMn] = static_cast<std::int32_t>(std::min(1e6, 1e3 * force.norm()));
  counters_[kPeakForceMn] = std::max(counters_[kPeakForceMn], counters_[kForceMn]);

  state.body_count = 3;
  auto& organ = state.bodies[kOrgan];
  organ.set_p(X_world_organ_.translation);
  organ.set_q(X_world_organ_.rotation);
  organ.set_v(velocity_);
  organ.set_w(spin_);
  auto& stylus = state.bodies[kStylus];
  stylus.visible = seen;
  auto& ball = state.bodies[kProxy];
  ball.visible = engaged_;
  if (seen) {
    const Vector3 lever = tip.X_world_tip.rotation * scene_.bat_offset;
    stylus.set_p(place + lever);
    stylus.set_q(tip.X_world_tip.rotation);
    stylus.set_v(tip.velocity + tip.angular_velocity.cross(lever));
    stylus.set_w(tip.angular_velocity);
  }
  if (engaged_) {
    const Vector3 before = ball.p();
    ball.set_p((X_world_organ_ * Point<Organ>{proxy_.state().position}).m);
    ball.set_q(stylus.q());
    ball.set_v(!touching ? tip.velocity : h > 0.0 ? Vector3((ball.p() - before) / h) : Vector3::Zero());
  }
  if (touching != touched || !engaged_) ++ball.jumps;  // no path is drawn across these
  state.counters = counters_;
  state.continuous.force = {force.x(), force.y(), force.z()};
  state.continuous.touching = touching ? 1 : 0;
  if (touching) {
    const Vector3 foot = proxy_.state().position - settings_.tip_radius * proxy_.state().normal;
    const Vector3 point = (X_world_organ_ * Point<Organ>{foot}).m;
    state.continuous.point = {point.x(), point.y(), point.z()};
  }
}

}  // namespace palpate::applications::touch
