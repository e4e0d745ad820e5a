// The thing to explore: the scene's mesh, or a closed, bumpy surface of about the size of a fist.
#pragma once

#include <cstdint>

#include "palpate/scene/application.h"
#include "palpate/scene/explored_surface.h"

namespace palpate::applications::touch {

struct Organ;  // frame: origin in the middle of what is touched, y up, x along the table's near edge to the
               // right

// Half axes of the smooth body, m; bumps stand out and in by up to kBump.
inline constexpr double kHalfWidth = 0.065, kHalfHeight = 0.040, kHalfDepth = 0.050, kBump = 0.0015;

// Centred at the origin, y up; 8 rings^2 triangles of about equal size, closed, every vertex shared. Throws
// std::invalid_argument for fewer than 2 rings.
scene::TriangleMesh organ_mesh(std::uint32_t rings = 112);

// What the scene lets one touch, in the Organ frame: its mesh, turned, the middle of its box at the origin;
// the organ where it has none. Physics, picture and player make it alike.
scene::TriangleMesh touched_mesh(const scene::SceneDescription& scene);
// The same to be looked at: the organ with as few triangles as keep its surface within 0.15 mm, a tenth of a
// pixel at 0.8 m; eight times fewer, as hundred thousand take a fifth of a second to draw in software.
scene::TriangleMesh drawn_mesh(const scene::SceneDescription& scene);
// From the origin down to its lowest place.
double height_below(const scene::SceneDescription& scene, const scene::TriangleMesh& touched);
// Where it rests: y up, x to the user's right, on the table shifted as the scene says. Throws
// std::invalid_argument where the scene has no table.
Pose<World, Organ> resting_place(const scene::SceneDescription& scene, const scene::TriangleMesh& touched);

// What a hand explores of it, before it moves.
scene::ExploredSurface explored_surface(const scene::SceneDescription& scene);

}  // namespace palpate::applications::touch
