#include "palpate/applications/touch/artist.h"

#include <fmt/format.h>

#include "palpate/applications/touch/organ.h"
#include "palpate/applications/touch/touch.h"

namespace palpate::touch {
namespace {
constexpr double kStylusLength_m = 0.12, kStylusRadius_m = 0.0025;

// What it stands on, where it is lifted off the table; a box in the Organ frame.
TriangleMesh plinth_under(const SceneDescription& scene, const TriangleMesh& touched) {
  constexpr double kLeast_m = 0.001, kShare = 0.3, kInside_m = 0.002;
  const double up = scene.touched.shift.y(), below = height_below(scene, touched);
  if (up < kLeast_m) return {};
  Vector3 half = Vector3::Zero();
  for (const auto& v : touched.vertices) half = half.cwiseMax(v.cwiseAbs());
  return box_mesh({-kShare * half.x(), -below - up, -kShare * half.z()},
                  {kShare * half.x(), kInside_m - below, kShare * half.z()});
}
}  // namespace

// The stylus is drawn at the proxy: a hand that presses sees the tip rest on the surface, not inside.
TouchArtist::TouchArtist(const SceneDescription& scene) : TouchArtist(scene, touched_mesh(scene)) {}

TouchArtist::TouchArtist(const SceneDescription& scene, const TriangleMesh& touched)
    : organ_(drawn_mesh(scene)),
      tip_(sphere_mesh(Settings{}.tip_radius)),
      plinth_(plinth_under(scene, touched)),
      X_world_rest_(resting_place(scene, touched)),
      stylus_(cylinder_mesh(Vector3::Zero(), {0.0, 0.0, kStylusLength_m}, kStylusRadius_m)) {}

std::vector<DrawItem> TouchArtist::draw(const WorldState& state) const {
  std::vector<DrawItem> items;
  if (state.body_count <= kProxy) return items;
  const auto& organ = state.bodies[kOrgan];
  items.push_back({&organ_, Material::bat_front, organ.q(), organ.p(), true});
  if (!plinth_.triangles.empty())
    items.push_back({&plinth_, Material::handle, X_world_rest_.rotation, X_world_rest_.translation, true});
  const auto& tip = state.bodies[kProxy];
  if (tip.visible == 0) return items;
  items.push_back(
      {&tip_, state.contact > 0.0 ? Material::highlight : Material::ball, tip.q(), tip.p(), true});
  items.push_back({&stylus_, Material::handle, tip.q(), tip.p(), true});
  return items;
}

std::vector<std::string> TouchArtist::captions(const WorldState& state) const {
  const auto& c = state.counters;
  return {fmt::format("force {:.2f} N", 1e-3 * c[kForceMn]),
          fmt::format("touches {}   peak {:.2f} N", c[kTouches], 1e-3 * c[kPeakForceMn])};
}

}  // namespace palpate::touch
