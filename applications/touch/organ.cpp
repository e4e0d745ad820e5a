#include "applications/touch/organ.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "applications/touch/settings.h"
#include "palpate/scene/table_frame.h"

namespace palpate::applications::touch {
namespace {

Vector3 on_surface(double latitude, double longitude) {
  const Vector3 u(std::cos(latitude) * std::cos(longitude), std::sin(latitude),
                  -std::cos(latitude) * std::sin(longitude));
  const Vector3 p(kHalfWidth * u.x(), kHalfHeight * u.y(), kHalfDepth * u.z());
  constexpr double kWave = 2.0 * std::numbers::pi / 0.030;  // bumps every 3 cm
  return p + kBump * std::sin(kWave * p.x()) * std::cos(kWave * p.z()) * std::cos(kWave * p.y()) * u;
}

// The mesh that a person brings; null: the organ.
const scene::TriangleMesh* brought(const scene::SceneDescription& scene) {
  return scene.mesh ? scene.mesh->mesh.get() : nullptr;
}

}  // namespace

// Rings of latitude like an octahedron's: 4 vertices on the first, 4 more on each to the equator, and back.
scene::TriangleMesh organ_mesh(std::uint32_t rings) {
  if (rings < 2)
    throw std::invalid_argument(
        fmt::format("organ: {} rings; 2 and more are expected, 112 make 100352 triangles", rings));
  scene::TriangleMesh mesh;
  const std::uint32_t last = 2 * rings;
  const auto size = [&](std::uint32_t r) { return 4 * std::min(r, last - r); };  // 0 at the poles
  std::vector<std::uint32_t> first;
  for (std::uint32_t r = 0; r <= last; ++r) {
    first.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    const double latitude = std::numbers::pi * (0.5 - static_cast<double>(r) / last);
    const std::uint32_t count = std::max(1u, size(r));
    for (std::uint32_t i = 0; i < count; ++i)
      mesh.vertices.push_back(on_surface(latitude, 2.0 * std::numbers::pi * i / count));
  }
  const auto at = [&](std::uint32_t r, std::uint32_t i) {
    return first[r] + (size(r) == 0 ? 0 : i % size(r));
  };
  for (std::uint32_t r = 0; r < last; ++r) {
    // The narrow ring of the two has n vertices in a quarter, the wide one n + 1.
    const bool widening = r < rings;
    const std::uint32_t narrow = widening ? r : r + 1, wide = widening ? r + 1 : r, n = size(narrow) / 4;
    for (std::uint32_t quarter = 0; quarter < 4; ++quarter) {
      for (std::uint32_t i = 0; i <= n; ++i) {
        const std::uint32_t a = at(narrow, quarter * n + i);
        const std::uint32_t b = at(wide, quarter * (n + 1) + i), c = at(wide, quarter * (n + 1) + i + 1);
        mesh.triangles.push_back(widening ? std::array{a, b, c} : std::array{a, c, b});
        if (i == n) continue;
        const std::uint32_t d = at(narrow, quarter * n + i + 1);
        mesh.triangles.push_back(widening ? std::array{a, c, d} : std::array{a, d, c});
      }
    }
  }
  return mesh;
}

scene::TriangleMesh drawn_mesh(const scene::SceneDescription& scene) {
  constexpr std::uint32_t kDrawnRings = 40;
  return brought(scene) == nullptr ? organ_mesh(kDrawnRings) : touched_mesh(scene);
}

scene::TriangleMesh touched_mesh(const scene::SceneDescription& scene) {
  if (brought(scene) == nullptr) return organ_mesh();
  scene::TriangleMesh mesh = *brought(scene);
  const Quaternion turn = rotation_from_xyz(surface_settings(scene).turn);
  Vector3 low = Vector3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (auto& v : mesh.vertices) {
    v = turn * v;
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const Vector3 middle = 0.5 * (low + high);
  for (auto& v : mesh.vertices) v -= middle;
  return mesh;
}

// The organ's bumps reach a little below its smooth body, into the table, as a soft thing lies.
double height_below(const scene::SceneDescription& scene, const scene::TriangleMesh& touched) {
  if (brought(scene) == nullptr) return kHalfHeight;
  double lowest = 0.0;
  for (const auto& v : touched.vertices) lowest = std::min(lowest, v.y());
  return -lowest;
}

Pose<World, Organ> resting_place(const scene::SceneDescription& scene, const scene::TriangleMesh& touched) {
  constexpr double kFromEdge_m = 0.11;  // of the middle, before the shift
  const double height = height_below(scene, touched);
  const scene::TableFrame table = scene::table_frame(scene);
  const Vector3 shift = surface_settings(scene).shift;
  return {table.rotation, table.edge + shift.x() * table.right + (height + shift.y()) * table.up +
                              (shift.z() - kFromEdge_m) * table.near};
}

}  // namespace palpate::applications::touch
