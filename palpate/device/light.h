// The light in the room: one lamp with a size, and what comes back from the walls; and how a camera writes
// light into bytes.
//
// World frame, metres; light is linear, 1 on a white surface is the brightest a picture holds. The rig file
// says them (sections [light] and [camera]); simulated camera and virtual things are lit by the same numbers.
// Plain values.
#pragma once

#include <cstdint>

#include "palpate/math/so3.h"

namespace palpate::device {

struct RoomLight {
  Vector3 lamp{0.45, 0.55, 1.95};  // centre
  double lamp_radius = 0.11;       // makes the edges of shadows soft
  double key = 0.95;               // of the lamp, on a white surface facing it
  double ambient = 0.42;           // from above; from below half of it
};

// root: bytes hold the square root of light (the simulated camera). srgb: IEC 61966-2-1, image files and
// nearly all webcams. linear: raw values of a sensor.
enum class Encoding : std::uint8_t { root, srgb, linear };

}  // namespace palpate::device
