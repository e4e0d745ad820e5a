// When and where a moving sphere first touches triangles: exact for faces, edges and vertices.
//
// A sphere of radius R meets a triangle when its centre meets the triangle grown by R: one offset plate,
// three cylinders, three spheres, which together are convex. Fractions of the motion count from 0 to 1. All
// in the mesh's frame unless said. Queries are const, allocate nothing and may run in several threads.
// Source: docs/theory/collision.md (Ericson 2005, chapter 5; Moeller and Trumbore 1997 for the ray).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "palpate/geometry/pose.h"
#include "palpate/scene/mesh.h"

namespace palpate {

struct SweepHit {
  double fraction = 0.0;  // of the motion; 0 also where the sphere overlaps at the start and goes deeper
  Vector3 normal = Vector3::UnitY();  // from the surface to the sphere's centre, unit
  Vector3 point = Vector3::Zero();    // on the surface
  std::uint32_t triangle = 0;
  bool overlapped = false;  // touched already at the start
};

using Triangle = std::array<Vector3, 3>;

Vector3 closest_point(const Triangle& t, const Vector3& p);

// First touch of a sphere going straight from `from` to `to`. A sphere that overlaps at the start hits at
// once if it goes deeper and not at all if it leaves (the grown triangle is convex: it cannot come back).
std::optional<SweepHit> sweep_sphere(const Triangle& t, const Vector3& from, const Vector3& to,
                                     double radius);

// The paper's test: where the ray of the centre crosses the triangle, both sides, fraction in [0, 1].
std::optional<double> ray_triangle(const Triangle& t, const Vector3& from, const Vector3& to);

// A mesh prepared for queries: brute force for small ones, a tree of boxes from 64 triangles on.
class CollisionMesh {
 public:
  CollisionMesh() = default;
  // Throws std::invalid_argument where an index has no vertex or a vertex is not finite.
  explicit CollisionMesh(const TriangleMesh& mesh);

  std::optional<SweepHit> sweep(const Vector3& from, const Vector3& to, double radius) const;
  // First crossing of the ray of the centre; normal of the face, on the side the ray comes from.
  std::optional<SweepHit> ray(const Vector3& from, const Vector3& to) const;
  // Places, for at(), of all triangles whose boxes meet the box from `low` to `high`; those in `places` go.
  // Allocates nothing where its capacity suffices, as one of size() always does.
  void in_box(const Vector3& low, const Vector3& high, std::vector<std::uint32_t>& places) const;
  const Triangle& at(std::uint32_t place) const { return triangles_[place]; }
  std::uint32_t number(std::uint32_t place) const { return index_[place]; }  // in the mesh it came from
  std::size_t size() const { return triangles_.size(); }
  double extent() const { return extent_; }  // largest distance of a vertex from the origin

 private:
  struct Box {
    Vector3 low, high;
  };
  struct Node {
    Box box;
    std::uint32_t first = 0, count = 0;  // leaf: triangles [first, first + count); inner: count = 0, children
    std::uint32_t left = 0, right = 0;
  };
  std::uint32_t build(std::uint32_t first, std::uint32_t last);
  template <typename Test>
  void visit(const Vector3& from, const Vector3& to, double margin, Test&& test) const;

  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> index_;  // of each triangle in the mesh it came from
  std::vector<Node> nodes_;
  double extent_ = 0.0;
};

// The same for a mesh that moves from `before` to `after` while the sphere flies: the path is taken into the
// mesh's frame at both ends. Where rotation bends that path by more than 0.1 mm the motion is split. Point
// and normal come back in W, the latter as of the moment of touch.
template <typename W, typename M>
std::optional<SweepHit> sweep_moving(const CollisionMesh& mesh, const Pose<W, M>& before,
                                     const Pose<W, M>& after, const Vector3& from, const Vector3& to,
                                     double radius) {
  constexpr double kBend = 1e-4;
  constexpr int kMostParts = 64;
  const double angle = angle_between(before.rotation, after.rotation);
  const double reach = mesh.extent() + radius;  // a point further away cannot touch
  // Seen from the mesh a straight path of length d bends by (a^2 r + 2 a d) / 8 while the mesh turns by a.
  const double travel = ((to - from) - (after.translation - before.translation)).norm();
  const double bend = angle * (angle * reach + 2.0 * travel) / 8.0;
  int parts = 1;
  while (parts < kMostParts && bend / (parts * parts) > kBend) parts *= 2;
  for (int i = 0; i < parts; ++i) {
    const double s0 = static_cast<double>(i) / parts, s1 = static_cast<double>(i + 1) / parts;
    const auto X0 = interpolate(before, after, s0), X1 = interpolate(before, after, s1);
    const Vector3 p0 = (X0.inverse() * Point<W>{from + s0 * (to - from)}).m;
    const Vector3 p1 = (X1.inverse() * Point<W>{from + s1 * (to - from)}).m;
    if (auto hit = mesh.sweep(p0, p1, radius)) {
      hit->overlapped = hit->overlapped && i == 0;
      hit->fraction = s0 + hit->fraction * (s1 - s0);
      const auto X = interpolate(before, after, hit->fraction);
      hit->normal = X.rotation * hit->normal;
      hit->point = (X * Point<M>{hit->point}).m;
      return hit;
    }
  }
  return std::nullopt;
}

}  // namespace palpate
