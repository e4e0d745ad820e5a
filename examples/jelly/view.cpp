#include "view.h"

#include <fmt/format.h>

#include "application.h"

namespace jelly {
namespace {

using palpate::Vector3;
using palpate::scene::Look;

// Colour; mirror straight on, at the edge, the lamp's image.
constexpr Look kRaspberry{{0.50f, 0.012f, 0.045f}, 0.030f, 0.30f, 0.45f};
constexpr Look kPorcelain{{0.70f, 0.70f, 0.66f}, 0.030f, 0.20f, 0.10f};
constexpr Look kSteel{{0.34f, 0.36f, 0.38f}, 0.100f, 0.30f, 0.20f};
constexpr Look kTipLook{{0.86f, 0.30f, 0.035f}, 0.010f, 0.10f, 0.10f};
constexpr double kStylusLength = 0.13, kStylusRadius = 0.0028;

palpate::scene::TriangleMesh stand() {
  constexpr double kPlate = 0.086, kThick = 0.005, kFoot = 0.012, kBase = 0.045;
  using palpate::scene::append;
  using palpate::scene::cylinder_mesh;
  const auto up = [](double y) { return Vector3(0.0, y, 0.0); };
  auto mesh = cylinder_mesh(up(-kThick), up(-0.0005), kPlate, 64);
  append(mesh, cylinder_mesh(up(kThick - kStandHeight), up(-kThick), kFoot, 32));
  append(mesh, cylinder_mesh(up(0.0005 - kStandHeight), up(kThick - kStandHeight), kBase, 48));
  return mesh;
}

}  // namespace

JellyView::JellyView(const palpate::scene::SceneDescription&)
    : jelly_(mould()),
      stand_(stand()),
      stylus_(palpate::scene::cylinder_mesh(Vector3::Zero(), {0.0, 0.0, kStylusLength}, kStylusRadius)),
      tip_(palpate::scene::sphere_mesh(kTipRadius)) {}

std::vector<palpate::scene::DrawItem> JellyView::draw(const palpate::scene::SceneState& state) const {
  std::vector<palpate::scene::DrawItem> items;
  if (state.body_count <= kTip) return items;
  const auto& jelly = state.bodies[kJelly];
  items.push_back(
      {.mesh = &jelly_, .look = kRaspberry, .rotation = jelly.q(), .position = jelly.p(), .deforms = true});
  items.push_back({.mesh = &stand_, .look = kPorcelain, .rotation = jelly.q(), .position = jelly.p()});
  const auto& tip = state.bodies[kTip];
  if (tip.visible == 0) return items;
  items.push_back({.mesh = &tip_,
                   .look = kTipLook,
                   .rotation = tip.q(),
                   .position = tip.p(),
                   .sphere_radius = kTipRadius});
  items.push_back({.mesh = &stylus_, .look = kSteel, .rotation = tip.q(), .position = tip.p()});
  return items;
}

std::vector<std::string> JellyView::captions(const palpate::scene::SceneState& state) const {
  const auto& c = state.counters;
  return {fmt::format("force {:.2f} N   dent {:.1f} mm", 1e-3 * c[kForceMn], 1e-3 * c[kDentUm])};
}

}  // namespace jelly
