// Where the vertices of a deforming surface are at one moment. What the triangles between them are the
// application knows on both sides; over the network goes only what changes.
#pragma once

#include <cstddef>
#include <memory>
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

// `newest` carried on to `time` as each of its numbers has changed since `before`; both of one size, `before` earlier. Normals
// are then a little off unit length.
inline std::shared_ptr<const Shape> carried_on(const Shape& before, const Shape& newest,
                                               Instant<PhysicsClock> time) {
  const auto share =
      static_cast<float>(to_seconds(time - newest.time) / to_seconds(newest.time - before.time));
  auto ahead = std::make_shared<Shape>(Shape{time, newest.values});
  for (std::size_t i = 0; i < ahead->values.size(); ++i)
    ahead->values[i] += share * (newest.values[i] - before.values[i]);
  return ahead;
}

}  // namespace palpate::scene
