// Triangle mesh: plain data shared by collision and picture.
#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "palpate/math/so3.h"

namespace palpate::scene {

// Which state of its vertices and triangles a mesh is in. Who keeps something made from a mesh (normals, a copy
// on the graphics card) sees by it that the mesh has changed, without looking at every vertex.
//
// No two meshes of a process have one number, nor have two states of one mesh: a copy gets a number of its own,
// for it may be changed next, and what has been moved takes its number along. So a mesh that comes to lie where
// another one lay is not taken for it.
class MeshVersion {
 public:
  MeshVersion() : number_(next()) {}
  MeshVersion(const MeshVersion&) : MeshVersion() {}
  MeshVersion(MeshVersion&& other) noexcept : number_(std::exchange(other.number_, next())) {}
  MeshVersion& operator=(const MeshVersion&) {
    raise();
    return *this;
  }
  MeshVersion& operator=(MeshVersion&& other) noexcept {
    number_ = std::exchange(other.number_, next());
    return *this;
  }
  ~MeshVersion() = default;

  // For whoever has changed a mesh in place that may have been drawn before.
  void raise() { number_ = next(); }
  std::uint64_t number() const { return number_; }  // never 0

 private:
  static std::uint64_t next() noexcept;  // any thread
  std::uint64_t number_;
};

// Vertices in metres in the mesh's own frame; triangles counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Vector3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  MeshVersion version;
};

// A rectangle spanned from `corner` by `side_x` and `side_y`, normal side_x x side_y: two triangles.
TriangleMesh rectangle_mesh(const Vector3& corner, const Vector3& side_x, const Vector3& side_y);

// A flat disc of `radius` and `thickness` in the x-z plane, centred at the origin, axis y, closed.
TriangleMesh disc_mesh(double radius, double thickness, int segments = 32);

// Sphere around the origin, latitude-longitude.
TriangleMesh sphere_mesh(double radius, int rings = 24, int segments = 48);

// Closed cylinder from a to b.
TriangleMesh cylinder_mesh(const Vector3& a, const Vector3& b, double radius, int segments = 20);

// A ring of a round wire in the x-z plane, centred at the origin, axis y; `radius`: of the wire's middle. `segments`
// straight, closed pieces.
TriangleMesh ring_mesh(double radius, double wire_radius, int segments = 36);

// Axis-aligned box.
TriangleMesh box_mesh(const Vector3& low, const Vector3& high);

void append(TriangleMesh& mesh, const TriangleMesh& other);

}  // namespace palpate::scene
