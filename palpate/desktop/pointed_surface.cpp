#include "palpate/desktop/pointed_surface.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

#include "palpate/scene/mesh_normals.h"

namespace palpate::desktop {
namespace {

constexpr double kFarthestSeen_m = 10.0;
constexpr double kMostLevel = 0.05;  // a ray more level than this meets the plane nowhere sensible

double lowest_along(const scene::TriangleMesh& mesh, const Vector3& up) {
  if (mesh.triangles.empty())
    throw std::invalid_argument("pointed surface: a mesh without triangles; one to point at is expected");
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& v : mesh.vertices) lowest = std::min(lowest, up.dot(v));
  return lowest;
}

}  // namespace

PointedSurface::PointedSurface(scene::ExploredSurface explored, const Vector3& up)
    : explored_(std::move(explored)),
      up_(up),
      lowest_(lowest_along(explored_.mesh, up)),
      highest_(-lowest_along(explored_.mesh, -up)),
      normals_(scene::vertex_normals(explored_.mesh)),
      mesh_(explored_.mesh) {}

std::optional<PointedSurface::Place> PointedSurface::under(const Vector3& eye, const Vector3& along) const {
  const Vector3 far = eye + kFarthestSeen_m * along;
  if (const auto hit = mesh_.ray(eye, far)) {
    const Vector3 at = eye + hit->fraction * (far - eye);
    const auto& t = explored_.mesh.triangles[hit->triangle];
    const Vector3 &a = explored_.mesh.vertices[t[0]], &b = explored_.mesh.vertices[t[1]],
                  &c = explored_.mesh.vertices[t[2]];
    // Each corner's share: the area opposite to it, seen along the triangle's normal.
    const Vector3 area = (b - a).cross(c - a);
    const double all = std::max(area.squaredNorm(), std::numeric_limits<double>::min());
    const double of_b = (at - a).cross(c - a).dot(area) / all, of_c = (b - a).cross(at - a).dot(area) / all;
    const Vector3 normal =
        (1.0 - of_b - of_c) * normals_[t[0]] + of_b * normals_[t[1]] + of_c * normals_[t[2]];
    return Place{at, normal.norm() > 0.0 ? Vector3(normal.normalized()) : hit->normal, true};
  }
  const double down = -up_.dot(along);
  if (down < kMostLevel) return std::nullopt;
  return Place{eye + (up_.dot(eye) - lowest_) / down * along, up_, false};
}

}  // namespace palpate::desktop
