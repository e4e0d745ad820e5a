// How things look that belong to no application: the onlooker's figures and furniture, marks over the
// picture, real things in a view from outside. Values.
#pragma once

#include "palpate/scene/draw_item.h"

namespace palpate::render {

// Colour; mirror straight on, at the edge, the lamp's image (scene::Look).
inline constexpr scene::Look kHighlightLook{{0.16f, 0.62f, 0.22f}, 0.030f, 0.20f, 0.20f};
inline constexpr scene::Look kFigureLook{{0.52f, 0.42f, 0.34f}, 0.010f, 0.06f, 0.02f};
inline constexpr scene::Look kCameraLook{{0.045f, 0.050f, 0.060f}, 0.030f, 0.20f, 0.30f};
inline constexpr scene::Look kSightLook{{0.85f, 0.72f, 0.04f}, 0.0f, 0.0f, 0.0f};
inline constexpr scene::Look kFloorLook{{0.33f, 0.27f, 0.21f}, 0.0f, 0.0f, 0.0f};
inline constexpr scene::Look kFloorShadeLook{{0.21f, 0.17f, 0.135f}, 0.0f, 0.0f, 0.0f};
inline constexpr scene::Look kFurnitureLook{{0.10f, 0.10f, 0.105f}, 0.01f, 0.05f, 0.05f};
// Real things in a view from outside: level surfaces, upright ones, the arm, registered bodies.
inline constexpr scene::Look kLevelLook{{0.13f, 0.20f, 0.30f}, 0.0f, 0.0f, 0.0f};
inline constexpr scene::Look kUprightLook{{0.42f, 0.42f, 0.40f}, 0.0f, 0.0f, 0.0f};
inline constexpr scene::Look kArmLook{{0.17f, 0.175f, 0.19f}, 0.02f, 0.10f, 0.06f};
inline constexpr scene::Look kBodyLook{{0.55f, 0.50f, 0.45f}, 0.01f, 0.05f, 0.02f};

}  // namespace palpate::render
