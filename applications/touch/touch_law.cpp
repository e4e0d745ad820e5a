#include "applications/touch/touch_law.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "palpate/scene/carry_on.h"

namespace palpate::applications::touch {
namespace {

// Depth at which the damper has its full size: it begins without a jump.
constexpr double kDampFrom_m = 0.0005;

SurfaceSettings checked(const SurfaceSettings& m) {
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
  return m;
}

}  // namespace

TouchLaw::TouchLaw(const SurfaceSettings& settings, const scene::TriangleMesh& surface, double tip_radius,
                   const Pose<World, Organ>& rest)
    : surface_(surface),
      stiffness_(checked(settings).stiffness),
      damping_(settings.damping),
      mesh_(surface_),
      proxy_(mesh_, {.radius = tip_radius,
                     .friction = settings.friction,
                     .static_friction = settings.static_friction}) {
  organ_.X_world_organ = rest;
}

// Looking away from the middle: nothing there, or a triangle seen from its outer side.
bool TouchLaw::outside(const Vector3& p) const {
  const Vector3 away = p.norm() > 0.0 ? Vector3(p.normalized()) : Vector3::UnitY();
  const auto seen = mesh_.ray(p, p + 2.0 * mesh_.extent() * away);
  if (!seen) return true;
  const auto& t = surface_.triangles[seen->triangle];
  const Vector3& a = surface_.vertices[t[0]];
  return (surface_.vertices[t[1]] - a).cross(surface_.vertices[t[2]] - a).dot(away) < 0.0;
}

// The virtual coupling, in the organ's frame: a spring between tip and proxy, and along the normal a damper,
// which never pulls the tip down.
Vector3 TouchLaw::pull(const Vector3& tip, const Vector3& velocity) const {
  const physics::ProxyState& s = proxy_.state();
  if (!s.touching) return Vector3::Zero();
  const double share = std::min(1.0, s.depth / kDampFrom_m);
  const double spring = stiffness_ * s.normal.dot(s.position - tip);
  const double damper = std::max(-spring, -damping_ * share * s.normal.dot(velocity));
  return stiffness_ * (s.position - tip) + damper * s.normal;
}

void TouchLaw::follow(const scene::TipState& tip, double dt) {
  Touching& now = touching_;
  const Vector3 place = tip.X_world_tip.translation;
  const bool seen = place.allFinite() && tip.velocity.allFinite();
  if (!seen || (place - tip_before_).norm() > kTeleport_m) now.engaged = false;
  if (seen) tip_before_ = place;

  // What the organ sees: its own motion is the tip's, the other way round.
  const Pose<World, Organ> X_world_organ = scene::carried_on(organ_.X_world_organ, organ_, tip.time);
  const auto X_organ_world = X_world_organ.inverse();
  const Vector3 p = (X_organ_world * Point<World>{place}).m;
  const bool touched = now.engaged && now.proxy.touching, slid = touched && now.proxy.sliding;
  if (seen && !now.engaged && proxy_.clear_at(p) && outside(p)) {
    now.engaged = true;
    proxy_.begin(p);
  }
  now.force.setZero();
  if (now.engaged) {
    const physics::ProxyState& proxy = proxy_.follow(p);
    now.unsettled += !proxy.settled;
    const Vector3 lever = place - X_world_organ.translation;
    const Vector3 relative = tip.velocity - organ_.velocity - organ_.spin.cross(lever);
    now.force = X_world_organ.rotation * pull(p, X_organ_world.rotation * relative);
    now.touches += proxy.touching && !touched;
    now.contact_s += proxy.touching ? dt : 0.0;
    now.slips += touched && proxy.sliding && !slid;
  }
  if (const double size = now.force.norm(); size > kBound_n) now.force *= kBound_n / size;
  now.tip = tip_before_;
  now.proxy = proxy_.state();
  const bool touching = now.engaged && now.proxy.touching;
  if (touching != touched || !now.engaged) ++now.jumps;
}

Vector3 TouchLaw::force(const scene::TipState& tip, double dt) noexcept {
  motion_.read(organ_);
  if (organ_.resets != touching_.resets) {
    touching_.touches = touching_.slips = touching_.unsettled = 0;
    touching_.contact_s = touching_.peak_n = 0.0;
    touching_.resets = organ_.resets;
  }
  follow(tip, dt);
  if (organ_.paused) touching_.force.setZero();
  touching_.peak_n = std::max(touching_.peak_n, touching_.force.norm());
  found_.write(touching_);
  return touching_.force;
}

}  // namespace palpate::applications::touch
