// The triangles around a place, laid out for many sweeps of one sphere that stays near it.
//
// A sphere that touches a surface has a hundred triangles within its radius and two or three in its way. The
// patch keeps what tells them apart cheaply: a ball around each triangle and the plane through it.
// Mesh frame, SI. One thread; after construction nothing is allocated.
#pragma once

#include <optional>
#include <vector>

#include "palpate/physics/sweep.h"

namespace palpate {

class SurfacePatch {
 public:
  // The mesh must outlive the patch.
  SurfacePatch(const CollisionMesh& mesh, double radius);

  // From here on paths may lie in the cube of half-side `reach` around `centre`.
  void gather(const Vector3& centre, double reach);
  bool covers(const Vector3& p) const { return (p - centre_).lpNorm<Eigen::Infinity>() <= reach_; }
  const Vector3& centre() const { return centre_; }
  double reach() const { return reach_; }  // negative: nothing gathered yet

  // As CollisionMesh::sweep, for a path that is covered.
  std::optional<SweepHit> sweep(const Vector3& from, const Vector3& to) const;

 private:
  struct Face {
    Vector3 centre;  // of the ball that holds the triangle
    double bound;    // its radius
    Vector3 normal;  // unit, or 0 where the triangle has no area
    double offset;   // normal . x of its plane
  };

  const CollisionMesh& mesh_;
  double radius_;
  Vector3 centre_ = Vector3::Zero();
  double reach_ = -1.0;
  std::vector<std::uint32_t> places_;  // in the mesh
  std::vector<Face> faces_;            // of places_
};

}  // namespace palpate
