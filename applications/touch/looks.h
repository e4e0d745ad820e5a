// What the touched surface, its plinth and the stylus look like. Values.
#pragma once

#include <array>
#include <string_view>

#include "palpate/scene/draw_item.h"

namespace palpate::applications::touch {

// Colour; mirror straight on, at the edge, the lamp's image (scene::Look).
// Of the touched surface, by the names of the setting; the first where nobody says.
struct NamedLook {
  std::string_view name;
  scene::Look look;
};
inline constexpr std::array<NamedLook, 6> kColours{
    {{"red", {{0.42f, 0.020f, 0.018f}, 0.015f, 0.12f, 0.06f}},
     {"liver", {{0.20f, 0.045f, 0.030f}, 0.020f, 0.14f, 0.08f}},
     {"bone", {{0.62f, 0.56f, 0.44f}, 0.010f, 0.08f, 0.04f}},
     {"grey", {{0.28f, 0.29f, 0.30f}, 0.015f, 0.12f, 0.06f}},
     {"blue", {{0.035f, 0.13f, 0.40f}, 0.015f, 0.12f, 0.06f}},
     {"yellow", {{0.60f, 0.40f, 0.040f}, 0.015f, 0.12f, 0.06f}}}};
inline const scene::Look& surface_look(std::string_view name) {
  for (const auto& colour : kColours)
    if (colour.name == name) return colour.look;
  return kColours.front().look;
}
inline constexpr scene::Look kWoodLook{{0.48f, 0.28f, 0.12f}, 0.020f, 0.10f, 0.10f};  // plinth, stylus
inline constexpr scene::Look kTipLook{{0.86f, 0.30f, 0.035f}, 0.010f, 0.10f, 0.10f};
inline constexpr scene::Look kTouchingTipLook{{0.16f, 0.62f, 0.22f}, 0.030f, 0.20f, 0.20f};

inline constexpr scene::Look kContactLook{
    {0.20f, 0.78f, 0.28f}, 0.010f, 0.05f, 0.05f};  // ring, line of force

}  // namespace palpate::applications::touch
