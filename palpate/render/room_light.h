// The light in the room, and the encoding of pictures, as shaders have them.
//
// The simulated camera and the virtual things over its picture are lit by the same numbers, in linear light.
// World frame, metres. Pure functions but for set_light (thread: the context's).
#pragma once

#include <string>

#include "palpate/device/light.h"
#include "palpate/math/so3.h"
#include "palpate/render/gl_objects.h"

namespace palpate::render {

void set_light(Program& program, const device::RoomLight& light);

// GLSL: uniforms `lamp`, `key`, `ambient`; functions
//   vec3 lit(vec3 albedo, vec3 p, vec3 n, float visible, float open)     matt; `open`: share of the room it
//   sees vec3 gloss(vec3 p, vec3 n, vec3 eye, float visible)                  the lamp's mirror image, white
extern const char* const kLightGlsl;

// GLSL: vec3 encode(vec3 linear), vec3 decode(vec3 encoded): light to bytes (0..1) and back.
std::string encoding_glsl(device::Encoding encoding);

}  // namespace palpate::render
