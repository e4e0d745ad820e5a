// A closed surface of rings like an octahedron's latitudes: 4 vertices on the first ring, 4 more on each to the widest,
// and back, a single vertex at both ends; so triangles are nearly alike all over it.
//
// `widest` >= 2: which ring that is, of 2 widest + 1. `place` is called with a ring, 0 at the first end, and the angle
// around, 0 to 2 pi rad; seen from outside with ring 0 up, the angle grows so that triangles are counter-clockwise.
// Pure function, any thread.
#pragma once

#include <cstdint>
#include <functional>

#include "palpate/scene/mesh.h"

namespace palpate::scene {

TriangleMesh ringed_mesh(std::uint32_t widest, const std::function<Vector3(std::uint32_t, double)>& place);

}  // namespace palpate::scene
