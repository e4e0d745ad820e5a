// Puts in order what mesh files hold: equal vertices become one, triangles without an area or there twice are
// dropped, neighbours face the same way, closed parts outwards.
//
// Two triangles are neighbours where they share an edge that no third one has. A part is what neighbours hold
// together. An open part keeps the way most of its triangles face. No tolerance has a unit. Pure; cost grows
// as n log n.
#pragma once

#include <cstddef>
#include <string>

#include "palpate/scene/mesh.h"

namespace palpate::scene {

struct MeshRepair {
  std::size_t welded_vertices = 0;     // merged into an equal one
  std::size_t dropped_triangles = 0;   // without an area
  std::size_t repeated_triangles = 0;  // there already, whichever way it faces
  std::size_t turned_triangles = 0;
  // What stays as it is, and can be known:
  std::size_t parts = 0;
  std::size_t open_edges = 0;       // of one triangle only
  std::size_t branching_edges = 0;  // of three or more
  bool one_sided = false;           // a part, such as a Moebius strip, that cannot face one way

  bool closed() const { return open_edges == 0 && branching_edges == 0; }
  // One line for a person.
  std::string text() const;
};

// Indices must be in range. May leave no triangle at all.
MeshRepair repair(TriangleMesh& mesh);

}  // namespace palpate::scene
