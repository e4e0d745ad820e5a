#include "palpate/applications/touch/touch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "palpate/applications/touch/organ.h"

namespace palpate::touch {
namespace {

constexpr double kFromEdge_m = 0.11;  // the organ's middle
constexpr double kTeleport_m = 0.05;  // a tip that moves further in one step was put there, not moved
constexpr double kDampFrom_m =
    0.0005;  // depth at which the damper has its full size: it begins without a jump

const Settings& checked_settings(const Settings& s) {
  if (!(s.stiffness > 0.0 && s.stiffness <= 800.0))
    throw std::invalid_argument(fmt::format(
        "touch: stiffness {} N/m; more than 0 and at most 800 is expected, which such an arm renders",
        s.stiffness));
  if (!(s.damping >= 0.0 && s.damping <= 3.0))
    throw std::invalid_argument(fmt::format("touch: damping {} N s/m; 0 to 3 is expected", s.damping));
  if (!(s.sway_hz >= 0.0 && s.sway_hz <= 5.0) || !(std::abs(s.sway_m) <= 0.05) ||
      !(std::abs(s.sway_rad) <= 0.5))
    throw std::invalid_argument(
        fmt::format("touch: a sway of {} Hz, {} m, {} rad; at most 5 Hz, 0.05 m, 0.5 rad is expected",
                    s.sway_hz, s.sway_m, s.sway_rad));
  return s;
}

// y up, x to the user's right, standing on the table.
Pose<World, Organ> place_on_table(const SceneDescription& scene) {
  const auto table = std::find_if(scene.surfaces.begin(), scene.surfaces.end(),
                                  [](const SceneSurface& s) { return s.name == "table"; });
  if (table == scene.surfaces.end())
    throw std::invalid_argument("touch: the scene has no surface 'table'; run `palpate calibrate surface`");
  const auto& c = table->corners;
  const Vector3 right = (c[1] - c[0]).normalized();
  const Vector3 up = (c[1] - c[0]).cross(c[3] - c[0]).normalized();
  Matrix3 R;
  R << right, up, right.cross(up);
  const Vector3 edge = 0.5 * (c[0] + c[1]);
  return {Quaternion(R), edge - kFromEdge_m * right.cross(up) + kHalfHeight * up};
}

}  // namespace

Touch::Touch(const SceneDescription& scene, const Settings& settings)
    : scene_(scene),
      settings_(checked_settings(settings)),
      surface_(organ_mesh(settings.rings)),
      mesh_(surface_),
      proxy_(mesh_, settings.proxy),
      X_world_rest_(place_on_table(scene)),
      X_world_organ_(X_world_rest_) {}

void Touch::control(Control command) {
  switch (command) {
    case Control::none:
      break;
    case Control::serve:
      swaying_ = !swaying_;
      break;
    case Control::pause:
      paused_ = true;
      break;
    case Control::resume:
      paused_ = false;
      break;
    case Control::reset:
      counters_.fill(0);
      contact_s_ = 0.0;
      break;
  }
}

void Touch::move_organ(double dt) {
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
bool Touch::outside(const Vector3& p) const {
  const Vector3 away = p.norm() > 0.0 ? Vector3(p.normalized()) : Vector3::UnitY();
  const auto seen = mesh_.ray(p, p + 2.0 * mesh_.extent() * away);
  if (!seen) return true;
  const auto& t = surface_.triangles[seen->triangle];
  const Vector3& a = surface_.vertices[t[0]];
  return (surface_.vertices[t[1]] - a).cross(surface_.vertices[t[2]] - a).dot(away) < 0.0;
}

// The virtual coupling, in the organ's frame: a spring between tip and proxy, and along the normal a damper,
// which never pulls the tip down.
Vector3 Touch::pull(const Vector3& tip, const Vector3& velocity) const {
  const ProxyState& s = proxy_.state();
  if (!s.touching) return Vector3::Zero();
  const double share = std::min(1.0, s.depth / kDampFrom_m);
  const double spring = settings_.stiffness * s.normal.dot(s.position - tip);
  const double damper = std::max(-spring, -settings_.damping * share * s.normal.dot(velocity));
  return settings_.stiffness * (s.position - tip) + damper * s.normal;
}

void Touch::step(Instant<PhysicsClock> /*now*/, Duration dt, const TipState& tip, WorldState& state) {
  const double h = to_seconds(dt);
  if (h > 0.0) move_organ(h);
  const Vector3 place = tip.X_world_tip.translation;
  const bool seen = place.allFinite() && tip.velocity.allFinite();
  if (!seen || (place - tip_before_).norm() > kTeleport_m) engaged_ = false;
  if (seen) tip_before_ = place;

  // What the organ sees: its own motion is the tip's, the other way round.
  const auto X_organ_world = X_world_organ_.inverse();
  const Vector3 p = (X_organ_world * Point<World>{place}).m;
  const bool touched = engaged_ && proxy_.state().touching;
  if (seen && !engaged_ && proxy_.clear_at(p) && outside(p)) {
    engaged_ = true;
    proxy_.begin(p);
  }
  Vector3 force = Vector3::Zero();
  if (engaged_) {
    const ProxyState& proxy = proxy_.follow(p);
    counters_[kUnsettled] += !proxy.settled;
    const Vector3 lever = place - X_world_organ_.translation;
    const Vector3 relative = tip.velocity - velocity_ - spin_.cross(lever);
    force = X_world_organ_.rotation * pull(p, X_organ_world.rotation * relative);
    counters_[kTouches] += proxy.touching && !touched;
    contact_s_ += proxy.touching ? h : 0.0;
  }
  if (paused_) force.setZero();
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
  const bool touching = engaged_ && proxy_.state().touching;
  if (engaged_) {
    const Vector3 before = ball.p();
    ball.set_p((X_world_organ_ * Point<Organ>{proxy_.state().position}).m);
    ball.set_q(stylus.q());
    ball.set_v(!touching ? tip.velocity : h > 0.0 ? Vector3((ball.p() - before) / h) : Vector3::Zero());
  }
  if (touching != touched || !engaged_) ++ball.jumps;  // no path is drawn across these
  state.counters = counters_;
  state.force = {force.x(), force.y(), force.z()};
  state.contact = touching ? 1.0 : 0.0;
  if (touching) {
    const Vector3 foot = proxy_.state().position - settings_.proxy.radius * proxy_.state().normal;
    const Vector3 point = (X_world_organ_ * Point<Organ>{foot}).m;
    state.contact_point = {point.x(), point.y(), point.z()};
  }
}

}  // namespace palpate::touch
