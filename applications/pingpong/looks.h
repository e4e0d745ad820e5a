// What ball and bat look like. Values.
#pragma once

#include "palpate/scene/draw_item.h"

namespace palpate::applications::pingpong {

// Colour; mirror straight on, at the edge, the lamp's image (scene::Look).
inline constexpr scene::Look kBallLook{{0.86f, 0.30f, 0.035f}, 0.010f, 0.10f, 0.10f};
inline constexpr scene::Look kFrontLook{{0.42f, 0.020f, 0.018f}, 0.015f, 0.12f, 0.06f};
inline constexpr scene::Look kBackLook{{0.022f, 0.022f, 0.024f}, 0.020f, 0.14f, 0.06f};
inline constexpr scene::Look kStringLook{{0.62f, 0.60f, 0.55f}, 0.015f, 0.10f, 0.05f};
inline constexpr scene::Look kHandleLook{{0.48f, 0.28f, 0.12f}, 0.020f, 0.10f, 0.10f};

}  // namespace palpate::applications::pingpong
