// The thing to explore: a closed, bumpy surface of about the size of a fist.
#pragma once

#include <cstdint>

#include "palpate/scene/mesh.h"

namespace palpate::touch {

// Half axes of the smooth body, m; bumps stand out and in by up to kBump.
inline constexpr double kHalfWidth = 0.065, kHalfHeight = 0.040, kHalfDepth = 0.050, kBump = 0.0015;

// Centred at the origin, y up; 8 rings^2 triangles of about equal size, closed, every vertex shared. Throws
// std::invalid_argument for fewer than 2 rings.
TriangleMesh organ_mesh(std::uint32_t rings = 112);

}  // namespace palpate::touch
