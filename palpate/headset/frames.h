// The frames of an OpenXR runtime, as empty types. Right-handed, metres; x right, y up, z towards who looks.
#pragma once

namespace palpate::headset {

struct Local;  // the runtime's LOCAL space: where the head was at the start, upright
struct View;   // between the eyes, turns with the head; it looks along -z
struct
    Panel;  // a flat picture: origin in its middle, x to its right, y to its upper edge, z out of its front

}  // namespace palpate::headset
