// Triangle meshes as people bring them: STL (binary and text), OBJ, PLY (text and binary little-endian).
//
// The format is told by the content. The files say nothing of their unit: the caller gives the length of one
// in metres. Read are the triangles and, cut into triangles, the polygons; colours, normals and textures are
// skipped. What was read is repaired (mesh_repair.h), and the repair told of. Errors: wrong use, with file
// and line or number of the triangle: not finite, further away than kFarthestPlace, index out of range, cut
// off, no triangle with an area, more than kMostTriangles.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "palpate/core/expected.h"
#include "palpate/scene/mesh.h"
#include "palpate/scene/mesh_repair.h"

namespace palpate::scene {

struct MeshFile {
  std::string source, hash;
  TriangleMesh mesh;  // m
  MeshRepair repaired;
};

inline constexpr std::size_t kMostTriangles = 20'000'000;

Expected<MeshFile> read_mesh(const std::filesystem::path& path, double metres_per_unit);
Expected<MeshFile> parse_mesh(std::string_view content, std::string source, double metres_per_unit);

// The parsers of each format: vertices in the file's unit, indices in range, nothing repaired.
Expected<TriangleMesh> parse_stl(std::string_view content, const std::string& source);
Expected<TriangleMesh> parse_obj(std::string_view content, const std::string& source);
Expected<TriangleMesh> parse_ply(std::string_view content, const std::string& source);

}  // namespace palpate::scene
