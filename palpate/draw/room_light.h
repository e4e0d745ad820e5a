// The light in the room: one lamp with a size, and what comes back from the walls.
//
// The simulated camera and the virtual things over its picture are lit by the same numbers, in linear light;
// pictures hold the square root of it (a display gamma of 2, cheap to undo). World frame, metres. Plain
// values.
#pragma once

#include "palpate/draw/gl_objects.h"
#include "palpate/geometry/so3.h"

namespace palpate::draw {

struct RoomLight {
  Vector3 lamp{0.45, 0.55, 1.95};  // centre
  double lamp_radius = 0.11;       // makes the edges of shadows soft
  double key = 0.95;               // of the lamp, on a white surface facing it
  double ambient = 0.42;           // from above; from below half of it
};

void set_light(Program& program, const RoomLight& light);

// GLSL: uniforms `lamp`, `key`, `ambient`; functions
//   vec3 lit(vec3 albedo, vec3 p, vec3 n, float visible, float open)     matt; `open`: share of the room it
//   sees vec3 gloss(vec3 p, vec3 n, vec3 eye, float visible)                  the lamp's mirror image, white
//   vec3 encode(vec3 linear)
extern const char* const kLightGlsl;

}  // namespace palpate::draw
