#include "mould.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "palpate/scene/table_frame.h"

namespace jelly {
namespace {

using palpate::Vector3;

constexpr int kFlutes = 9;
constexpr double kFluteDepth = 0.055, kSteepness = 0.72;  // shares of the radius; 1: an ellipsoid

Vector3 on_dome(double down, double round) {  // rad from the top, rad about the vertical
  const double side = std::sin(down);
  const double radius = kRadius * side * (1.0 + kFluteDepth * side * side * std::cos(kFlutes * round));
  const double height = kHeight * std::pow(std::max(0.0, std::cos(down)), kSteepness);
  return {radius * std::cos(round), height, -radius * std::sin(round)};
}

std::uint32_t first_of(std::size_t ring) {
  return static_cast<std::uint32_t>(ring == 0 ? 0 : 1 + 3 * ring * (ring - 1));
}

}  // namespace

palpate::scene::TriangleMesh mould() {
  palpate::scene::TriangleMesh mesh;
  mesh.vertices.push_back(on_dome(0.0, 0.0));
  for (std::size_t ring = 1; ring <= kRings; ++ring)
    for (std::size_t i = 0; i < 6 * ring; ++i)
      mesh.vertices.push_back(
          on_dome(0.5 * std::numbers::pi * static_cast<double>(ring) / kRings,
                  2.0 * std::numbers::pi * static_cast<double>(i) / (6.0 * static_cast<double>(ring))));
  // Each sixth of a ring joins n vertices further in with n + 1 further out.
  for (std::uint32_t ring = 1; ring <= kRings; ++ring) {
    const auto inner = [&](std::uint32_t i) {
      return first_of(ring - 1) + (ring == 1 ? 0 : i % (6 * (ring - 1)));
    };
    const auto outer = [&](std::uint32_t i) { return first_of(ring) + i % (6 * ring); };
    for (std::uint32_t sixth = 0; sixth < 6; ++sixth) {
      for (std::uint32_t i = 0; i < ring; ++i) {
        const std::uint32_t a = sixth * (ring - 1) + i, b = sixth * ring + i;
        mesh.triangles.push_back({inner(a), outer(b), outer(b + 1)});
        if (i + 1 < ring) mesh.triangles.push_back({inner(a), outer(b + 1), inner(a + 1)});
      }
    }
  }
  return mesh;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_of(const palpate::scene::TriangleMesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) edges.emplace_back(std::minmax(t[k], t[(k + 1) % 3]));
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

std::vector<Vector3> areas_of(const palpate::scene::TriangleMesh& mesh) {
  std::vector<Vector3> areas(mesh.vertices.size(), Vector3::Zero());
  for (const auto& t : mesh.triangles) {
    const Vector3& a = mesh.vertices[t[0]];
    const Vector3 area = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a) / 6.0;
    for (const std::uint32_t corner : t) areas[corner] += area;
  }
  return areas;
}

Vector3 outward(const Vector3& place) {
  const Vector3 slope(place.x() / (kRadius * kRadius), std::max(0.0, place.y()) / (kHeight * kHeight),
                      place.z() / (kRadius * kRadius));
  return slope.norm() > 1e-9 ? Vector3(slope.normalized()) : Vector3(Vector3::UnitY());
}

palpate::Pose<palpate::World, JellyFrame> place_on_table(const palpate::scene::SceneDescription& scene) {
  constexpr double kToTheRight = 0.08, kFromEdge = 0.07;  // m, from the middle of the near edge
  const auto table = palpate::scene::table_frame(scene);
  return {table.rotation,
          table.edge + kToTheRight * table.right + kStandHeight * table.up - kFromEdge * table.near};
}

}  // namespace jelly
