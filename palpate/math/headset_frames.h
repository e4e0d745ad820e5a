// The frames of a head-mounted display, as empty types. Right-handed, metres; x right, y up, z towards who looks.
#pragma once

namespace palpate::inline math {

struct HeadsetLocal;  // OpenXR's LOCAL space: where the head was at the start, upright
struct HeadsetEyes;   // OpenXR's VIEW space: between the eyes, turns with the head; it looks along -z

}  // namespace palpate::inline math
