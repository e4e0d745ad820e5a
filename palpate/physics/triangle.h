// One triangle: its closest point, when a sphere on a straight path first touches it, where a ray crosses it.
//
// A sphere of radius R meets a triangle when its centre meets the triangle grown by R: one offset plate,
// three cylinders, three spheres, which together are convex. Any frame, any unit of length: no tolerance has
// one. A triangle thinner than 1e-8 of its longest edge counts as its edges, which is the same to rounding.
// Pure functions. Source: docs/theory/collision.md (Ericson 2005, chapter 5; Woop, Benthin and Wald 2013 for
// the ray).
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "palpate/math/so3.h"

namespace palpate::physics {

struct SweepHit {
  double fraction = 0.0;  // of the motion; 0 also where the sphere overlaps at the start and goes deeper
  Vector3 normal = Vector3::UnitY();  // from the surface to the sphere's centre, unit
  Vector3 point = Vector3::Zero();    // on the surface
  std::uint32_t triangle = 0;
  bool overlapped = false;  // touched already at the start
};

using Triangle = std::array<Vector3, 3>;

Vector3 closest_point(const Triangle& t, const Vector3& p);

// First touch of a sphere of radius > 0 going straight from `from` to `to`. A sphere that overlaps at the
// start hits at once if it goes deeper and not at all if it leaves (the grown triangle is convex: it cannot
// come back). A path that is not finite touches nothing. Of touches after the fraction `latest` nothing
// need be told, which most triangles are then spared for.
std::optional<SweepHit> sweep_sphere(const Triangle& t, const Vector3& from, const Vector3& to, double radius,
                                     double latest = 1.0);

// Where the ray of the centre crosses the triangle, both sides, fraction in [0, 1]. Watertight: between two
// triangles that share an edge no ray slips through. Nothing where it runs in the triangle's plane.
std::optional<double> ray_triangle(const Triangle& t, const Vector3& from, const Vector3& to);

}  // namespace palpate::physics
