#include "palpate/scene/mesh_file.h"

#include <cmath>

#include "palpate/core/file.h"
#include "palpate/core/little_endian.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/scene/mesh_text.h"

namespace palpate::scene {
namespace {

// A binary STL says by its length what it is; some of them begin with "solid" nevertheless.
bool is_stl(std::string_view content) {
  if (content.size() >= 84) {
    const auto count = little_endian<std::uint32_t>(content.data() + 80);
    if (content.size() == 84 + 50 * static_cast<std::size_t>(count)) return true;
  }
  return content.substr(0, 5) == "solid";
}

// The first word that is no comment is one of OBJ's.
bool is_obj(std::string_view content) {
  mesh_text::Lines lines(content);
  for (std::string_view line; lines.next(line);) {
    const auto first = mesh_text::word(line);
    if (first.empty() || first.front() == '#') continue;
    for (const std::string_view known : {"v", "vt", "vn", "f", "o", "g", "s", "mtllib", "usemtl"})
      if (first == known) return true;
    return false;
  }
  return false;
}

Expected<TriangleMesh> parse_any(std::string_view content, const std::string& source) {
  if (content.substr(0, 3) == "ply") return parse_ply(content, source);
  if (is_stl(content)) return parse_stl(content, source);
  if (is_obj(content)) return parse_obj(content, source);
  // Not a length that fits a binary STL: most often one that was cut off.
  const auto extension = std::filesystem::path(source).extension();
  if (extension == ".stl" || extension == ".STL") return parse_stl(content, source);
  return wrong_use("{}: is no mesh; STL, OBJ or PLY is expected", source);
}

}  // namespace

Expected<MeshFile> read_mesh(const std::filesystem::path& path, double metres_per_unit) {
  const auto content = read_file(path, kMostMeshBytes);
  if (!content) return tl::unexpected(content.error());
  return parse_mesh(*content, path.string(), metres_per_unit);
}

Expected<MeshFile> parse_mesh(std::string_view content, std::string source, double metres_per_unit) {
  if (!(metres_per_unit > 0.0) || !std::isfinite(metres_per_unit))
    return wrong_use("{}: one unit is {} m; a length above 0 is expected, 0.001 for millimetres", source,
                     metres_per_unit);
  if (content.empty()) return wrong_use("{}: is empty; STL, OBJ or PLY is expected", source);
  auto mesh = parse_any(content, source);
  if (!mesh) return tl::unexpected(mesh.error());
  for (std::size_t i = 0; i < mesh->vertices.size(); ++i) {
    auto& v = mesh->vertices[i];
    if (!v.allFinite())
      return wrong_use("{}: vertex {} is ({}, {}, {}); finite numbers are expected, repair or remove it",
                       source, i + 1, v.x(), v.y(), v.z());
    v *= metres_per_unit;
    if (!(v.cwiseAbs().maxCoeff() <= kFarthestPlace))
      return wrong_use("{}: vertex {} is {:.3g} m away, at most {:.0e} m is expected; check the unit", source,
                       i + 1, v.cwiseAbs().maxCoeff(), kFarthestPlace);
  }
  const std::size_t read = mesh->triangles.size();
  MeshFile file;
  file.repaired = repair(*mesh);
  if (mesh->triangles.empty())
    return wrong_use("{}: holds {}, none with an area; at least one is expected", source,
                     counted(read, "triangle"));
  file.source = std::move(source);
  file.hash = content_hash(content);
  file.mesh = std::move(*mesh);
  return file;
}

}  // namespace palpate::scene
