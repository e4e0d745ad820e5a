// How far a point is from a closed surface, and on which side.
//
// Signed distance: positive outside, negative inside. The side is told by the normal of the nearest face, or by
// the mean of the faces around the nearest edge or vertex, weighted by their angles, which is right for every
// closed surface, sharp or not. Metres, the mesh's frame. Const, any thread, no allocation after construction.
// Source: Baerentzen and Aanaes 2005, "Signed distance computation using the angle weighted pseudonormal",
// IEEE Trans. Visualization and Computer Graphics 11.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/math/so3.h"
#include "palpate/physics/triangle.h"
#include "palpate/scene/mesh.h"

namespace palpate::physics::tissue {

struct SurfacePlace {
  double distance = 0.0;              // signed
  Vector3 foot = Vector3::Zero();     // the nearest point of the surface
  Vector3 normal = Vector3::UnitZ();  // there, outwards, unit
};

class SurfaceDistance {
 public:
  // Refused: a surface that is not closed or not turned one way, numbers that are none, triangles without area.
  static Expected<SurfaceDistance> of(const scene::TriangleMesh& mesh);

  // Where the surface is further away than `most`, that is the distance, and neither side nor foot is told: the deep
  // inside, where all of a surface is equally far, takes long.
  SurfacePlace at(const Vector3& p, double most = std::numeric_limits<double>::infinity()) const;

 private:
  struct Box {
    Vector3 low, high;
    double distance2(const Vector3& p) const { return (p - p.cwiseMax(low).cwiseMin(high)).squaredNorm(); }
  };
  struct Node {
    Box box;
    std::uint32_t first = 0, count = 0;  // of a leaf's faces; count 0: the children are next and `first`
  };
  struct Face {
    Triangle corners;
    Vector3 normal;
    std::array<Vector3, 3> edge_normals, corner_normals;  // edge i: from corner i to the next
  };
  static constexpr std::uint32_t kLeaf = 4;
  static constexpr std::size_t kStack = 64;

  std::uint32_t build(std::uint32_t first, std::uint32_t last);

  std::vector<Face> faces_;
  std::vector<Node> nodes_;
};

}  // namespace palpate::physics::tissue
