// A block for a press on the middle of its top: small elements there, growing away from it.
//
// Metres; the origin is the middle of the top, z points up, the bottom lies at -size.z. A core, a box of equal
// cells below the origin, is wrapped in shells of boxes that grow by one factor until they reach the block's
// sides and bottom; every hexahedral cell is split in six tetrahedra. Pure function; it allocates.
#pragma once

#include <vector>

#include "palpate/core/expected.h"
#include "palpate/physics/deformable/tet_mesh.h"

namespace palpate::physics::deformable {

struct BoxMeshSettings {
  Vector3 size{0.1, 0.1, 0.05};
  // Only the half with x >= 0, or with y >= 0, is meshed: what is symmetric needs no more.
  bool half_x = false, half_y = false;
  double core = 0.006;        // half of the core's width
  double core_depth = 0.006;  // its height
  int cells = 6;              // across half of the core's width
  int cells_down = 6;
  int shells = 6;
};

// Refused: a core that does not fit in the block with a shell around it, counts below 1.
Expected<TetMesh> box_mesh(const BoxMeshSettings& settings);

// Nodes on a plane: coordinate `axis` equals `value` to a billionth of the largest size.
std::vector<int> nodes_on_plane(const TetMesh& mesh, int axis, double value);
// Facets with all corners on it.
std::vector<int> facets_on_plane(const TetMesh& mesh, int axis, double value);

}  // namespace palpate::physics::deformable
