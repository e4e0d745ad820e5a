#include "palpate/applications/touch/artist.h"

#include <fmt/format.h>

#include "palpate/applications/touch/organ.h"
#include "palpate/applications/touch/touch.h"

namespace palpate::touch {
namespace {
constexpr double kStylusLength_m = 0.12, kStylusRadius_m = 0.0025;
}  // namespace

// The stylus is drawn at the proxy: a hand that presses sees the tip rest on the surface, not inside.
TouchArtist::TouchArtist(const SceneDescription& /*scene*/)
    : organ_(organ_mesh(Settings{}.rings)),
      tip_(sphere_mesh(Settings{}.proxy.radius)),
      stylus_(cylinder_mesh(Vector3::Zero(), {0.0, 0.0, kStylusLength_m}, kStylusRadius_m)) {}

std::vector<DrawItem> TouchArtist::draw(const WorldState& state) const {
  std::vector<DrawItem> items;
  if (state.body_count <= kProxy) return items;
  const auto& organ = state.bodies[kOrgan];
  items.push_back({&organ_, Material::bat_front, organ.q(), organ.p(), true});
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
