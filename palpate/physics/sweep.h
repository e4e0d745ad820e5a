// When and where a moving sphere first touches a mesh: exact for faces, edges and vertices.
//
// Fractions of the motion count from 0 to 1. All in the mesh's frame unless said; any unit of length, the
// same for all. Queries are const, allocate nothing and may run in several threads.
// Source: docs/theory/collision.md.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "palpate/math/pose.h"
#include "palpate/physics/triangle.h"
#include "palpate/physics/triangle_tree.h"
#include "palpate/scene/mesh.h"

namespace palpate::physics {

// A mesh prepared for queries.
class CollisionMesh {
 public:
  CollisionMesh() = default;
  // Throws std::invalid_argument where an index has no vertex or a vertex is not finite.
  explicit CollisionMesh(const scene::TriangleMesh& mesh);

  // First touch of a sphere of radius > 0. Of several at the same time the one of the triangle with the
  // smallest index; of several overlaps at the start, into which it goes deeper, the deepest.
  std::optional<SweepHit> sweep(const Vector3& from, const Vector3& to, double radius) const;
  // First crossing of the ray of the centre; normal of the face, on the side the ray comes from.
  std::optional<SweepHit> ray(const Vector3& from, const Vector3& to) const;
  // Places, for at(), of all triangles that reach into the box from `low` to `high`, and of some whose boxes
  // alone do; those in `places` go.
  // Allocates nothing where its capacity suffices, as one of size() always does.
  void in_box(const Vector3& low, const Vector3& high, std::vector<std::uint32_t>& places) const;
  const Triangle& at(std::uint32_t place) const { return triangles_[place]; }
  std::uint32_t number(std::uint32_t place) const {
    return tree_.order()[place];
  }  // in the mesh it came from
  std::size_t size() const { return triangles_.size(); }
  double extent() const { return extent_; }  // largest distance of a vertex from the origin

 private:
  std::vector<Triangle> triangles_;  // in the order of the tree's leaves
  TriangleTree tree_;
  double extent_ = 0.0;
};

// Into how many equal parts sweep_moving() cuts a motion, so that within each the path that the mesh sees is
// straight to kBend of the sphere's radius (or kBendOfMesh of the mesh's extent, if that is more). Seen from
// a mesh that turns by a while it is passed at most r away, a straight path of length d bends by at most
// a (a r + 2 d) / 8; n parts bend by 1/n^2 of that. `angle` in radians, the others in the mesh's unit.
inline constexpr double kBend = 1.0 / 200.0, kBendOfMesh = 1.0 / 20000.0;
inline int sweep_parts(double angle, double travel, double extent, double radius) {
  constexpr double kMostParts = 1024.0;  // half a turn while flying past at ten times the extent needs 650
  const double reach = extent + radius + travel;  // further away no part of the motion can touch
  const double bend = angle * (angle * reach + 2.0 * travel) / 8.0;
  const double allowed = std::max(kBend * radius, kBendOfMesh * extent);
  if (bend <= allowed) return 1;
  return static_cast<int>(std::min(kMostParts, std::ceil(std::sqrt(bend / allowed))));
}

// The same for a mesh that moves from `before` to `after` while the sphere flies; from, to, point and normal
// in W, the latter two as of the moment of touch. Exact where the mesh only moves; where it turns, the touch
// is off by the bend above at most: 0.1 mm for a ball of 20 mm.
template <typename W, typename M>
std::optional<SweepHit> sweep_moving(const CollisionMesh& mesh, const Pose<W, M>& before,
                                     const Pose<W, M>& after, const Vector3& from, const Vector3& to,
                                     double radius) {
  // Passing far away is told without a rotation: the mesh's origin and the sphere's centre both go straight.
  const Vector3 start = from - before.translation;
  const Vector3 travel = (to - from) - (after.translation - before.translation);
  const double dd = travel.squaredNorm();
  const double nearest = dd > 0.0 ? std::clamp(-start.dot(travel) / dd, 0.0, 1.0) : 0.0;
  const double reach = (1.0 + 1e-9) * (mesh.extent() + radius);
  if ((start + nearest * travel).squaredNorm() > reach * reach) return std::nullopt;

  const int parts =
      sweep_parts(angle_between(before.rotation, after.rotation), std::sqrt(dd), mesh.extent(), radius);
  const auto seen_by_mesh = [&](double s) {
    const auto X = s == 0.0 ? before : s == 1.0 ? after : interpolate(before, after, s);
    return (X.inverse() * Point<W>{from + s * (to - from)}).m;
  };
  Vector3 p0 = seen_by_mesh(0.0);
  for (int i = 0; i < parts; ++i) {
    const double s0 = static_cast<double>(i) / parts, s1 = static_cast<double>(i + 1) / parts;
    const Vector3 p1 = seen_by_mesh(s1);
    if (auto hit = mesh.sweep(p0, p1, radius)) {
      hit->overlapped = hit->overlapped && i == 0;
      hit->fraction = s0 + hit->fraction * (s1 - s0);
      const auto X = interpolate(before, after, hit->fraction);
      hit->normal = X.rotation * hit->normal;
      hit->point = (X * Point<M>{hit->point}).m;
      return hit;
    }
    p0 = p1;
  }
  return std::nullopt;
}

}  // namespace palpate::physics
