// An organ's surface filled with elements, and held where it lies on the table. Metres, the surface's frame. It
// allocates.
#pragma once

#include <vector>

#include "palpate/core/expected.h"
#include "palpate/physics/deformable/solid.h"
#include "palpate/physics/deformable/tet_mesh.h"
#include "palpate/physics/tissue/surface_distance.h"
#include "palpate/scene/mesh.h"

namespace palpate::physics::organ {

struct OrganMesh {
  deformable::TetMesh mesh;
  deformable::FreeMotion motion;
  std::vector<int> surface_nodes;  // rising
};

// `distance` is that of the surface. Refused: one that is too thin for its elements, or stands on nothing.
Expected<OrganMesh> organ_mesh(const scene::TriangleMesh& surface, const tissue::SurfaceDistance& distance,
                               double element, const Vector3& up, double support);
// The same of elements that are there already, about so large.
Expected<OrganMesh> lay_down(deformable::TetMesh mesh, const scene::TriangleMesh& surface, double element,
                             const Vector3& up, double support);

}  // namespace palpate::physics::organ
