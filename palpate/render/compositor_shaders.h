// The compositor's shaders. GLSL 3.30, without #version.
#pragma once

#include <string>

#include "palpate/device/light.h"

namespace palpate::render {

// What of the shaders depends on the settings.
struct ShaderChoice {
  device::Encoding encoding = device::Encoding::root;
  int samples = 4;
  bool maps = true;  // bodies are shaded by shadow maps
};

std::string background_fragment();                          // the camera's image, lens undone
std::string over_fragment(const ShaderChoice& choice);      // and the virtual layer over it
extern const char* const kSolidVertex;                      // bodies, phantoms
std::string item_fragment(const ShaderChoice& choice);      // a body in its colour
std::string darkened_fragment(const ShaderChoice& choice);  // shadows of virtual bodies on real bodies
extern const char* const kNothingFragment;                  // depth only
extern const char* const kCatcherVertex;                    // shadows of virtual bodies on real surfaces
std::string catcher_fragment();

}  // namespace palpate::render
