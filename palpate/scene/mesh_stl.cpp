// STL: triangles one after the other, each with its own three corners. Binary: 80 bytes of header, a count,
// and 50 bytes for each: normal, corners, two bytes of anything. Text: `vertex x y z` between `facet` and
// `endfacet`. The normals are often wrong and are not used.
#include <algorithm>
#include <array>

#include "palpate/core/little_endian.h"
#include "palpate/core/text.h"
#include "palpate/scene/mesh_file.h"
#include "palpate/scene/mesh_text.h"

namespace palpate::scene {
namespace {

constexpr std::size_t kStlHeader = 84, kStlTriangle = 50;

void add_triangle(TriangleMesh& mesh, const std::array<Vector3, 3>& corners) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), corners.begin(), corners.end());
  mesh.triangles.push_back({first, first + 1, first + 2});
}

Expected<TriangleMesh> parse_binary_stl(std::string_view content, const std::string& source) {
  if (content.size() < kStlHeader)
    return wrong_use("{}: {} bytes; a binary STL of at least {} is expected, copy it again", source,
                     content.size(), kStlHeader);
  const std::size_t count = little_endian<std::uint32_t>(content.data() + 80);
  if (count > kMostTriangles)
    return wrong_use("{}: says it holds {} triangles, at most {} are expected; make it coarser", source,
                     count, kMostTriangles);
  if (content.size() != kStlHeader + kStlTriangle * count)
    return wrong_use("{}: says it holds {} triangles, which take {} bytes, but has {}; copy it again", source,
                     count, kStlHeader + kStlTriangle * count, content.size());
  TriangleMesh mesh;
  mesh.vertices.reserve(3 * count);
  mesh.triangles.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const char* at = content.data() + kStlHeader + kStlTriangle * i + 12;  // past the normal
    std::array<Vector3, 3> corners;
    for (auto& corner : corners)
      for (Eigen::Index k = 0; k < 3; ++k, at += 4) corner[k] = little_endian<float>(at);
    add_triangle(mesh, corners);
  }
  return mesh;
}

Expected<TriangleMesh> parse_text_stl(std::string_view content, const std::string& source) {
  TriangleMesh mesh;
  std::array<Vector3, 3> corners;
  std::size_t corner = 0;
  bool in_facet = false, in_solid = false;
  mesh_text::Lines lines(content);
  for (std::string_view line; lines.next(line);) {
    const auto key = mesh_text::word(line);
    if (key.empty() || key == "outer" || key == "endloop") continue;
    const auto unexpected = [&](const char* expected) {
      return wrong_use("{}:{}: '{}' where {} is expected; repair the line", source, lines.number(),
                       excerpt(key), expected);
    };
    if (key == "solid") {
      if (in_solid) return unexpected("facet or endsolid");
      in_solid = true;
    } else if (key == "facet") {
      if (!in_solid) return unexpected("solid");
      if (in_facet) return unexpected("vertex or endfacet");
      in_facet = true;
      corner = 0;
    } else if (key == "vertex") {
      if (!in_facet || corner == 3) return unexpected(in_facet ? "endfacet" : "facet");
      for (Eigen::Index k = 0; k < 3; ++k) {
        const auto cell = mesh_text::word(line);
        const auto value = mesh_text::number<double>(cell);
        if (!value)
          return wrong_use("{}:{}: '{}' is no coordinate; vertex x y z is expected", source, lines.number(),
                           excerpt(cell));
        corners[corner][k] = *value;
      }
      ++corner;
    } else if (key == "endfacet") {
      if (!in_facet || corner != 3) return unexpected("a facet of three vertices before it");
      in_facet = false;
      if (mesh.triangles.size() >= kMostTriangles)
        return wrong_use("{}: holds more than {} triangles; make it coarser", source, kMostTriangles);
      add_triangle(mesh, corners);
    } else if (key == "endsolid") {
      if (!in_solid || in_facet) return unexpected(in_facet ? "endfacet" : "solid");
      in_solid = false;
    } else {
      return unexpected("facet, vertex, endfacet or endsolid");
    }
  }
  if (in_solid)
    return wrong_use("{}: ends after {} without endsolid; it is cut off, copy it again", source,
                     counted(mesh.triangles.size(), "triangle"));
  return mesh;
}

}  // namespace

Expected<TriangleMesh> parse_stl(std::string_view content, const std::string& source) {
  if (content.size() >= kStlHeader) {
    const std::size_t count = little_endian<std::uint32_t>(content.data() + 80);
    if (content.size() == kStlHeader + kStlTriangle * count) return parse_binary_stl(content, source);
  }
  // Text, unless there are bytes that no text has.
  const auto head = content.substr(0, 1024);
  if (head.substr(0, 5) == "solid" && head.find('\0') == std::string_view::npos)
    return parse_text_stl(content, source);
  return parse_binary_stl(content, source);
}

}  // namespace palpate::scene
