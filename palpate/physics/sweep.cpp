#include "palpate/physics/sweep.h"

#include <stdexcept>

namespace palpate::physics {

CollisionMesh::CollisionMesh(const scene::TriangleMesh& mesh) {
  for (const auto& v : mesh.vertices) {
    if (!v.allFinite()) throw std::invalid_argument("collision mesh: a vertex is not finite");
    extent_ = std::max(extent_, v.norm());
  }
  triangles_.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    for (const auto i : t) {
      if (i >= mesh.vertices.size())
        throw std::invalid_argument("collision mesh: a triangle has no such vertex");
    }
    triangles_.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
  }
  tree_ = TriangleTree(triangles_);
}

std::optional<SweepHit> CollisionMesh::sweep(const Vector3& from, const Vector3& to, double radius) const {
  std::optional<SweepHit> best;
  double last = 1.0;
  tree_.visit(from, to, radius, last, [&](std::uint32_t i) {
    auto hit = sweep_sphere(triangles_[i], from, to, radius, last);
    if (!hit) return;
    hit->triangle = tree_.order()[i];
    const auto before = [&](double mine, double other) {
      return mine < other || (mine == other && hit->triangle < best->triangle);
    };
    if (!best || (hit->overlapped && !best->overlapped) ||
        (hit->overlapped == best->overlapped &&
         // of two overlaps at the start the deeper one shows the way out
         (hit->overlapped ? before((from - hit->point).squaredNorm(), (from - best->point).squaredNorm())
                          : before(hit->fraction, best->fraction)))) {
      best = hit;
      last = hit->fraction;
    }
  });
  return best;
}

void CollisionMesh::in_box(const Vector3& low, const Vector3& high,
                           std::vector<std::uint32_t>& places) const {
  places.clear();
  // By the ball around the box, which the tree takes for a sphere at rest.
  const Vector3 centre = 0.5 * (low + high);
  const double never_lowered = 1.0;
  tree_.visit(centre, centre, 0.5 * (high - low).norm(), never_lowered, [&](std::uint32_t i) {
    const auto& t = triangles_[i];
    if ((t[0].cwiseMin(t[1]).cwiseMin(t[2]).array() <= high.array()).all() &&
        (t[0].cwiseMax(t[1]).cwiseMax(t[2]).array() >= low.array()).all())
      places.push_back(i);
  });
}

std::optional<SweepHit> CollisionMesh::ray(const Vector3& from, const Vector3& to) const {
  std::optional<SweepHit> best;
  double last = 1.0;
  tree_.visit(from, to, 0.0, last, [&](std::uint32_t i) {
    const auto fraction = ray_triangle(triangles_[i], from, to);
    if (!fraction) return;
    const std::uint32_t triangle = tree_.order()[i];
    if (best && (*fraction > best->fraction || (*fraction == best->fraction && triangle > best->triangle)))
      return;
    const auto& t = triangles_[i];
    const Vector3 n = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
    best = SweepHit{*fraction, n.dot(to - from) > 0.0 ? Vector3(-n) : n, from + *fraction * (to - from),
                    triangle, false};
    last = *fraction;
  });
  return best;
}

}  // namespace palpate::physics
