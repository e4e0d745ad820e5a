// The mesh file that a scene names: read on the physics side, found again on the graphics side.
//
// Errors: wrong use for a file that is no mesh, of a size that no hand explores or too fine for a tick; refused
// where the graphics side has another file than the physics side.
#pragma once

#include <filesystem>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/scene/application.h"

namespace palpate::scene {

// Sides of the box around a mesh, m; and how many triangles a tick still goes through in time (bench/touch).
inline constexpr double kSmallestMesh = 0.005, kLargestMesh = 0.5;
inline constexpr std::size_t kMostMeshTriangles = 1'100'000;
inline constexpr std::size_t kMaxMeshPathBytes = 512;  // that the network carries

// Physics side: reads scene.mesh, if it names a file, and sets mesh and hash. Returns a line for a person: size,
// and what was put in order; empty without a file.
Expected<std::string> read_mesh_asset(SceneDescription& scene);

// Graphics side: the same mesh, from `given` or, where the physics server is on this machine, from the file
// it names.
Expected<void> find_mesh_asset(SceneDescription& scene, const std::filesystem::path& given,
                               bool same_machine);

}  // namespace palpate::scene
