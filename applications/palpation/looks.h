// What organ, tray, stylus, marks and nodules look like. Values.
#pragma once

#include "palpate/scene/draw_item.h"

namespace palpate::applications::palpation {

// Colour; mirror straight on, at the edge, the lamp's image (scene::Look).
inline constexpr scene::Look kLiverLook{{0.30f, 0.035f, 0.022f}, 0.024f, 0.20f, 0.34f};  // moist
// In place of the organ's own colour.
inline constexpr std::array<float, 3> kVeinColour{0.085f, 0.012f, 0.040f}, kPaleColour{0.52f, 0.20f, 0.13f},
    kStressedColour{0.95f, 0.62f, 0.03f};
inline constexpr scene::Look kStressLook{{0.035f, 0.060f, 0.16f}, 0.015f, 0.10f, 0.06f};
inline constexpr scene::Look kNetLook{{0.40f, 0.075f, 0.050f}, 0.015f, 0.10f, 0.06f};
inline constexpr scene::Look kTrayLook{{0.44f, 0.50f, 0.52f}, 0.040f, 0.20f, 0.12f};
inline constexpr scene::Look kStylusLook{{0.34f, 0.36f, 0.38f}, 0.100f, 0.30f, 0.20f};
inline constexpr scene::Look kTipLook{{0.86f, 0.30f, 0.035f}, 0.010f, 0.10f, 0.10f};
inline constexpr scene::Look kPressingTipLook{{0.85f, 0.62f, 0.04f}, 0.010f, 0.10f, 0.10f};
inline constexpr scene::Look kHardTipLook{{0.80f, 0.02f, 0.02f}, 0.010f, 0.10f, 0.10f};
inline constexpr scene::Look kMarkLook{{0.05f, 0.25f, 0.80f}, 0.010f, 0.10f, 0.10f};
inline constexpr scene::Look kRightMarkLook{{0.05f, 0.60f, 0.10f}, 0.010f, 0.10f, 0.10f};
// Not red, which the flesh around it is.
inline constexpr scene::Look kFalseMarkLook{{0.80f, 0.02f, 0.60f}, 0.010f, 0.10f, 0.10f};
inline constexpr scene::Look kNoduleLook{{0.80f, 0.72f, 0.50f}, 0.020f, 0.10f, 0.10f};
inline constexpr scene::Look kMissedNoduleLook{{0.85f, 0.38f, 0.05f}, 0.020f, 0.10f, 0.10f};

}  // namespace palpate::applications::palpation
