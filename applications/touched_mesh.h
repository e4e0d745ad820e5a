// The mesh that a person brings to be touched: read on the physics side, found again on the graphics side.
//
// Errors: wrong use for a file that is no mesh or of a size no hand explores, refused where the graphics side
// has another file than the physics side.
#pragma once

#include <filesystem>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/scene/application.h"

namespace palpate::applications {

// Sides of the box around a mesh, m; and how many triangles a tick still goes through in time (bench/touch).
inline constexpr double kSmallestTouched = 0.005, kLargestTouched = 0.5;
inline constexpr std::size_t kMostTouchedTriangles = 1'100'000;

// Physics side: reads scene.touched.mesh_file, if it names one, and sets mesh and mesh_hash. Returns a line
// for a person: size, and what was put in order; empty without a file.
Expected<std::string> read_touched_mesh(scene::SceneDescription& scene);

// Graphics side: the same mesh, from `given` or, where the physics server is on this machine, from the file
// it names.
Expected<void> find_touched_mesh(scene::SceneDescription& scene, const std::filesystem::path& given,
                                 bool same_machine);

}  // namespace palpate::applications
