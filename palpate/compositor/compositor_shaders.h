// The compositor's shaders. GLSL 3.30, without #version.
#pragma once

#include <string>

namespace palpate {

extern const char* const kUndistortFragment;  // background
extern const char* const kSolidVertex;        // bodies, phantoms
std::string item_fragment();
extern const char* const kNothingFragment;  // depth only
extern const char* const kCatcherVertex;    // shadows on real surfaces
std::string catcher_fragment();
extern const char* const kOverFragment;  // virtual layer over the background

}  // namespace palpate
