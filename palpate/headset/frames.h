// The frames of an OpenXR runtime, as empty types: palpate/math/headset_frames.h, by OpenXR's names.
#pragma once

#include "palpate/math/headset_frames.h"

namespace palpate::headset {

using Local = HeadsetLocal;
using View = HeadsetEyes;
struct
    Panel;  // a flat picture: origin in its middle, x to its right, y to its upper edge, z out of its front

}  // namespace palpate::headset
