// Triangle mesh: plain data shared by collision and picture.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "palpate/math/so3.h"

namespace palpate::scene {

// Vertices in metres in the mesh's own frame; triangles counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Vector3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

// A rectangle spanned from `corner` by `side_x` and `side_y`, normal side_x x side_y: two triangles.
TriangleMesh rectangle_mesh(const Vector3& corner, const Vector3& side_x, const Vector3& side_y);

// A flat disc of `radius` and `thickness` in the x-z plane, centred at the origin, axis y, closed.
TriangleMesh disc_mesh(double radius, double thickness, int segments = 32);

// Sphere around the origin, latitude-longitude.
TriangleMesh sphere_mesh(double radius, int rings = 24, int segments = 48);

// Closed cylinder from a to b.
TriangleMesh cylinder_mesh(const Vector3& a, const Vector3& b, double radius, int segments = 20);

// Axis-aligned box.
TriangleMesh box_mesh(const Vector3& low, const Vector3& high);

void append(TriangleMesh& mesh, const TriangleMesh& other);

}  // namespace palpate::scene
