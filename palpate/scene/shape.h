// Where the vertices of a deforming surface are at one moment. What the triangles between them are the
// application knows on both sides; over the network goes only what changes.
#pragma once

#include <cstddef>
#include <vector>

#include "palpate/time/instant.h"

namespace palpate::scene {

struct Shape {
  static constexpr std::size_t kFloatsPerVertex = 6;  // position x y z (m, World), normal x y z
  static constexpr std::size_t kMaxVertices = 40'000;

  Instant<PhysicsClock> time;
  std::vector<float> values;  // vertex after vertex

  std::size_t vertices() const { return values.size() / kFloatsPerVertex; }
};

}  // namespace palpate::scene
