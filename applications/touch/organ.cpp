#include "applications/touch/organ.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "applications/touch/settings.h"
#include "applications/touch/touch.h"
#include "palpate/scene/mesh_normals.h"
#include "palpate/scene/ringed_mesh.h"
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

scene::TriangleMesh organ_mesh(std::uint32_t rings) {
  if (rings < 2)
    throw std::invalid_argument(
        fmt::format("organ: {} rings; 2 and more are expected, 112 make 100352 triangles", rings));
  return scene::ringed_mesh(rings, [&](std::uint32_t ring, double longitude) {
    return on_surface(std::numbers::pi * (0.5 - static_cast<double>(ring) / (2 * rings)), longitude);
  });
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

scene::ExploredSurface explored_surface(const scene::SceneDescription& scene) {
  constexpr double kPress_m = 0.004, kFullForce_n = 3.0;
  const Pose<World, Organ> X_world_organ = resting_place(scene, touched_mesh(scene));
  scene::ExploredSurface explored;
  explored.mesh = scene::moved(drawn_mesh(scene), X_world_organ.rotation, X_world_organ.translation);
  explored.tip_radius = Settings{}.tip_radius;
  explored.press = explored.deepest = kPress_m;
  explored.full_force_n = kFullForce_n;
  return explored;
}

}  // namespace palpate::applications::touch
