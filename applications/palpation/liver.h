// The organ that is pressed: the scene's own mesh, or a liver-like body made here, and where it stands.
//
// The liver-like body: a smooth dome over an outline with two lobes and a notch between them, thicker on the right, a
// rounded rim, a flat underside; 390 cm^3, a quarter of an adult's, so that
// all of it lies in reach. Closed, every vertex shared, triangles of about equal size. Metres.
#pragma once

#include <cstdint>
#include <vector>

#include "palpate/physics/tissue/tissue_law.h"
#include "palpate/scene/application.h"
#include "palpate/scene/explored_surface.h"
#include "palpate/scene/mesh_normals.h"

namespace palpate::applications::palpation {

// Frame of organ, nodules and marks (physics::tissue::Body): origin in the middle of the underside, x along the
// table's near edge to the right, y up, z towards the person.
using Body = physics::tissue::Body;

// 16 rings^2 + 2 vertices are made of 2 rings of latitude above and as many below. Throws std::invalid_argument for
// fewer than 2 rings.
scene::TriangleMesh liver_mesh(std::uint32_t rings = 26);

// What the scene lets one press, in the frame Body. Physics, picture and player make it alike; throws
// std::invalid_argument for settings that are none.
scene::TriangleMesh pressed_mesh(const scene::SceneDescription& scene);
// Where it rests: on the table, or on the tray under it, shifted as the scene says. Throws std::invalid_argument
// where the scene has no table.
Pose<World, Body> resting_place(const scene::SceneDescription& scene);

// What a hand explores of it.
scene::ExploredSurface explored_surface(const scene::SceneDescription& scene);

double volume_of(const scene::TriangleMesh& mesh);  // m^3, of a closed mesh whose normals point outwards

}  // namespace palpate::applications::palpation
