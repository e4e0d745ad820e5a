// The colours of a session's window: one for what the person holds, one for where to hold it.
#pragma once

#include "palpate/desktop/canvas.h"

namespace palpate::desktop {

inline constexpr Colour kPageGround{22, 26, 32, 255}, kPageBox{34, 40, 48, 255}, kPageLine{70, 80, 92, 255},
    kInkWhite{245, 248, 250, 255}, kInkGrey{168, 178, 190, 255}, kPresent{92, 204, 255, 255},
    kGoal{255, 190, 60, 255}, kGood{90, 214, 130, 255}, kBad{240, 96, 76, 255}, kHeld{92, 204, 255, 120},
    kSurface{150, 164, 180, 200}, kEdge{10, 12, 16, 170};

}  // namespace palpate::desktop
