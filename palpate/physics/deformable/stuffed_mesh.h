// A closed surface filled with tetrahedra of nearly one size.
//
// A body-centred lattice is laid over the body; lattice points near the surface are moved onto it, and tetrahedra that
// the surface cuts are cut by fixed patterns. So no tetrahedron is flat, whatever the surface looks like; what is finer
// than the lattice is lost: thin rims and sharp edges are cut off. Metres, the surface's frame. Pure; it allocates.
// Source: Labelle, Shewchuk, Isosurface stuffing, ACM Trans. Graphics 26 (2007); which of two diagonals a face takes is
// chosen here by the angles that come of it.
#pragma once

#include <functional>

#include "palpate/core/expected.h"
#include "palpate/physics/deformable/tet_mesh.h"

namespace palpate::physics::deformable {

// Distance to the surface, negative inside; further away than the lattice's spacing only its sign counts.
using SignedDistance = std::function<double(const Vector3&)>;

struct StuffedMeshSettings {
  Vector3 low{0.0, 0.0, 0.0}, high{0.0, 0.0, 0.0};  // a box that holds the body
  double spacing = 0.01;                            // of the lattice; long edges have this length
};

// Quadratic, the middles of edges straight. Refused: no place inside, a body of several parts, a lattice of too many
// points. Wrong use: settings that make no sense.
Expected<TetMesh> stuffed_mesh(const SignedDistance& distance, const StuffedMeshSettings& settings);

}  // namespace palpate::physics::deformable
