#include "applications/touch/scene_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "applications/touch/looks.h"
#include "applications/touch/organ.h"
#include "applications/touch/settings.h"
#include "applications/touch/touch.h"

namespace palpate::applications::touch {
namespace {
constexpr double kStylusLength_m = 0.12, kStylusRadius_m = 0.0025;
// Of ring and line: at no force, and per newton.
constexpr double kRing_m = 0.009, kRingPerNewton_m = 0.003, kLine_m = 0.010, kLinePerNewton_m = 0.014;
constexpr double kWire_m = 0.0007, kForceStep_n = 0.25;

// What it stands on, where it is lifted off the table; a box in the Organ frame.
scene::TriangleMesh plinth_under(const scene::SceneDescription& scene, const scene::TriangleMesh& touched) {
  constexpr double kLeast_m = 0.001, kPlinthShare = 0.3, kInside_m = 0.002;
  const double up = surface_settings(scene).shift.y(), below = height_below(scene, touched);
  if (up < kLeast_m) return {};
  Vector3 half = Vector3::Zero();
  for (const auto& v : touched.vertices) half = half.cwiseMax(v.cwiseAbs());
  return scene::box_mesh({-kPlinthShare * half.x(), -below - up, -kPlinthShare * half.z()},
                         {kPlinthShare * half.x(), kInside_m - below, kPlinthShare * half.z()});
}
}  // namespace

// The stylus is drawn at the proxy: a hand that presses sees the tip rest on the surface, not inside.
TouchView::TouchView(const scene::SceneDescription& scene) : TouchView(scene, touched_mesh(scene)) {}

TouchView::TouchView(const scene::SceneDescription& scene, const scene::TriangleMesh& touched)
    : organ_(drawn_mesh(scene)),
      look_(surface_look(surface_settings(scene).colour)),
      tip_(scene::sphere_mesh(Settings{}.tip_radius)),
      plinth_(plinth_under(scene, touched)),
      X_world_rest_(resting_place(scene, touched)),
      stylus_(scene::cylinder_mesh(Vector3::Zero(), {0.0, 0.0, kStylusLength_m}, kStylusRadius_m)) {
  for (std::size_t i = 0; i < kForces; ++i) {
    const double force = kForceStep_n * static_cast<double>(i);
    rings_[i] = scene::ring_mesh(kRing_m + kRingPerNewton_m * force, kWire_m, 24);
    lines_[i] =
        scene::cylinder_mesh(Vector3::Zero(), {0.0, kLine_m + kLinePerNewton_m * force, 0.0}, kWire_m, 8);
  }
}

void TouchView::add_contact(const scene::SceneState& state, std::vector<scene::DrawItem>& items) const {
  const Vector3 force(state.continuous.force.data());
  if (state.continuous.touching == 0 || !(force.norm() > 0.0)) return;
  const auto step = static_cast<std::size_t>(
      std::lround(std::min(force.norm() / kForceStep_n, static_cast<double>(kForces - 1))));
  const Quaternion along = rotation_between(Vector3::UnitY(), force.normalized());
  const Vector3 point(state.continuous.point.data());
  items.push_back({&rings_[step], kContactLook, along, point});
  items.push_back({&lines_[step], kContactLook, along, point});
}

std::vector<scene::DrawItem> TouchView::draw(const scene::SceneState& state) const {
  std::vector<scene::DrawItem> items;
  if (state.body_count <= kProxy) return items;
  const auto& organ = state.bodies[kOrgan];
  items.push_back({&organ_, look_, organ.q(), organ.p(), true});
  if (!plinth_.triangles.empty())
    items.push_back({&plinth_, kWoodLook, X_world_rest_.rotation, X_world_rest_.translation, true});
  const auto& tip = state.bodies[kProxy];
  if (tip.visible == 0) return items;
  items.push_back({&tip_, state.continuous.touching != 0 ? kTouchingTipLook : kTipLook, tip.q(), tip.p(),
                   true, Settings{}.tip_radius});
  items.push_back({&stylus_, kWoodLook, tip.q(), tip.p(), true});
  add_contact(state, items);
  return items;
}

std::vector<std::string> TouchView::captions(const scene::SceneState& state) const {
  const auto& c = state.counters;
  return {fmt::format("touches {}", c[kTouches]), fmt::format("peak {:.2f} N", 1e-3 * c[kPeakForceMn])};
}

}  // namespace palpate::applications::touch
