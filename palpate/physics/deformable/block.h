// The meshed block of an indentation, held as it lies on its table.
//
// Metres, the frame of box_mesh.h. Of a block that is symmetric about the planes x = 0 or y = 0 a half or a quarter
// is meshed, and `copies` says how many make the whole. It allocates.
#pragma once

#include "palpate/physics/deformable/indentation.h"
#include "palpate/physics/deformable/solid.h"
#include "palpate/physics/deformable/tet_mesh.h"

namespace palpate::physics::deformable {

struct Block {
  TetMesh mesh;
  FreeMotion motion;
  double copies = 1.0;
};

// Elements of `widest` / fineness across a contact of radius `widest`.
Expected<Block> mesh_block(const Indentation& indentation, double widest);

}  // namespace palpate::physics::deformable
