// What the touched surface, its plinth and the stylus look like. Values.
#pragma once

#include "palpate/scene/draw_item.h"

namespace palpate::applications::touch {

// Colour; mirror straight on, at the edge, the lamp's image (scene::Look).
inline constexpr scene::Look kOrganLook{{0.42f, 0.020f, 0.018f}, 0.015f, 0.12f, 0.06f};
inline constexpr scene::Look kWoodLook{{0.48f, 0.28f, 0.12f}, 0.020f, 0.10f, 0.10f};  // plinth, stylus
inline constexpr scene::Look kTipLook{{0.86f, 0.30f, 0.035f}, 0.010f, 0.10f, 0.10f};
inline constexpr scene::Look kTouchingTipLook{{0.16f, 0.62f, 0.22f}, 0.030f, 0.20f, 0.20f};

inline constexpr scene::Look kContactLook{
    {0.20f, 0.78f, 0.28f}, 0.010f, 0.05f, 0.05f};  // ring, line of force

}  // namespace palpate::applications::touch
