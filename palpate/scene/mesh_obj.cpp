// OBJ: `v x y z`, `f 1 2 3` with indices from 1, or from -1 backwards; `f 1/4/7 ...` names texture and normal
// too. Faces of more corners are cut into a fan.
#include <algorithm>

#include "palpate/core/text.h"
#include "palpate/scene/mesh_file.h"
#include "palpate/scene/mesh_text.h"

namespace palpate::scene {
namespace {

// Words of OBJ that hold nothing of a surface.
bool skipped(std::string_view key) {
  for (const std::string_view known : {"vt", "vn", "g", "o", "s", "l", "p", "mtllib", "usemtl", "mg", "lod"})
    if (key == known) return true;
  return key.empty() || key.front() == '#';
}

}  // namespace

Expected<TriangleMesh> parse_obj(std::string_view content, const std::string& source) {
  TriangleMesh mesh;
  std::vector<std::uint32_t> face;
  mesh_text::Lines lines(content);
  for (std::string_view line; lines.next(line);) {
    const auto key = mesh_text::word(line);
    if (skipped(key)) continue;
    if (key == "v") {
      Vector3 v;
      for (Eigen::Index k = 0; k < 3; ++k) {
        const auto cell = mesh_text::word(line);
        const auto value = mesh_text::number<double>(cell);
        if (!value)
          return wrong_use("{}:{}: '{}' is no coordinate; v x y z is expected", source, lines.number(),
                           excerpt(cell));
        v[k] = *value;
      }
      if (mesh.vertices.size() >= 3 * kMostTriangles)
        return wrong_use("{}: holds more than {} vertices; make it coarser", source, 3 * kMostTriangles);
      mesh.vertices.push_back(v);
      continue;
    }
    if (key != "f")
      return wrong_use("{}:{}: '{}' is not read here; v and f are expected, export plain polygons", source,
                       lines.number(), excerpt(key));
    face.clear();
    for (auto cell = mesh_text::word(line); !cell.empty(); cell = mesh_text::word(line)) {
      const auto index = mesh_text::number<std::int64_t>(cell.substr(0, cell.find('/')));
      const auto count = static_cast<std::int64_t>(mesh.vertices.size());
      if (!index || *index == 0 || *index > count || *index < -count)
        return wrong_use("{}:{}: corner '{}' of a face; 1 to {} is expected, the vertices so far", source,
                         lines.number(), excerpt(cell), count);
      face.push_back(static_cast<std::uint32_t>(*index > 0 ? *index - 1 : count + *index));
    }
    if (face.size() < 3)
      return wrong_use("{}:{}: a face of {}; at least 3 are expected", source, lines.number(),
                       counted(face.size(), "corner"));
    for (std::size_t i = 2; i < face.size(); ++i) mesh.triangles.push_back({face[0], face[i - 1], face[i]});
    if (mesh.triangles.size() > kMostTriangles)
      return wrong_use("{}: holds more than {} triangles; make it coarser", source, kMostTriangles);
  }
  return mesh;
}

}  // namespace palpate::scene
