// The jelly as it comes out of its mould: a fluted dome, as a mesh of even triangles. Frame Jelly: origin in the middle
// of its base, x to the user's right, y up, z towards the user; m. Values.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "palpate/math/pose.h"
#include "palpate/scene/application.h"

namespace jelly {

struct JellyFrame;  // a tag for poses

inline constexpr double kRadius = 0.065, kHeight = 0.048;  // m
inline constexpr std::size_t kRings = 20;                  // 6 vertices on the first, 6 more on each
inline constexpr std::size_t kVertices = 1 + 3 * kRings * (kRings + 1);
inline constexpr std::size_t kRim = kVertices - 6 * kRings;  // from here on they stand on the plate

palpate::scene::TriangleMesh mould();
// Which vertices are neighbours, each pair once.
std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_of(const palpate::scene::TriangleMesh& mesh);
// A third of the areas round each vertex, along their normals, m^2.
std::vector<palpate::Vector3> areas_of(const palpate::scene::TriangleMesh& mesh);
// Where the surface faces that is nearest to this place: unit, of the dome without its flutes.
palpate::Vector3 outward(const palpate::Vector3& place);

// On its stand, on the surface "table". Throws std::invalid_argument where there is none.
palpate::Pose<palpate::World, JellyFrame> place_on_table(const palpate::scene::SceneDescription& scene);
inline constexpr double kStandHeight = 0.060;  // m: there the arm reaches all round

}  // namespace jelly
