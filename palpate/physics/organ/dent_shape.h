// What the surface of a soft body does under a tip, for the picture.
//
// Under the tip the dent of a half-space, as deep as the contact's own depth; everywhere the rest of the body's answer,
// which is smooth: known at sites for a force of one newton, at the nodes of the body's mesh, blended between the sites
// and carried to the vertices by the mesh's shape functions. A vertex that would lie in the tip lies on it. The body's
// frame, SI. Source: docs/theory/organ.md; Johnson, Contact Mechanics, section 3.4, for the half-space.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "palpate/math/so3.h"
#include "palpate/physics/deformable/surface_load.h"
#include "palpate/physics/deformable/tet_mesh.h"
#include "palpate/physics/organ/site_table.h"
#include "palpate/scene/mesh.h"

namespace palpate::physics::organ {

// Where a vertex hangs on the mesh: shares of the nodes of a facet.
struct Anchor {
  std::array<std::uint32_t, 6> nodes{};  // of the surface's, numbered as the rows of DentTable
  std::array<float, 6> shares{};
};
// On the facet that is nearest. `surface_nodes`: the mesh's nodes that are rows, rising.
std::vector<Anchor> anchors_of(const scene::TriangleMesh& surface, const deformable::TetMesh& mesh,
                               const std::vector<int>& surface_nodes);

// What a body answers to one newton at each site, pressed along -normal and spread as Hertz's pressure is, beyond what a
// half-space does.
struct DentTable {
  std::vector<deformable::SurfaceSite> sites;
  SiteTable rest;
};

// Displacement along the force of a half-space's surface at this distance from the middle of Hertz's pressure, in parts
// of that in the middle; distance in contact radii.
double half_space_profile(double distance);

class DentShape {
 public:
  // Throws std::invalid_argument where tables and anchors do not fit one another.
  DentShape(const scene::TriangleMesh& surface, std::vector<Anchor> anchors, DentTable table,
            double tip_radius);

  // Places of all vertices, body's frame, for a tip whose centre is at `tip`, `depth` deep, that is pushed back by
  // `force` (N, on the tip; along the normal, without friction and viscosity). No allocation; one thread at a time.
  void press(const Vector3& tip, double depth, const Vector3& force, std::span<Vector3> vertices) const;

  const DentTable& table() const { return table_; }

 private:
  static constexpr std::size_t kBlended = 8;
  struct Share {
    double distance2, weight;
    std::size_t site;
  };
  std::size_t near(const Vector3& foot, const Vector3& normal, std::array<Share, kBlended + 1>& found) const;

  std::vector<Vector3> rest_;
  std::vector<Anchor> anchors_;
  DentTable table_;
  double radius_;
  mutable Eigen::VectorXf blended_;
};

}  // namespace palpate::physics::organ
