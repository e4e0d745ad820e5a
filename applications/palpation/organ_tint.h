// Colours of the organ's surface beside its own: veins under the capsule, paler where it is pressed; or its stress.
//
// A share for each vertex of the organ (scene::Tint). Vertices and shapes: the organ's, in the frame Body and in World.
// One thread.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "palpate/physics/deformable/elasticity.h"
#include "palpate/scene/draw_item.h"

namespace palpate::applications::palpation {

// How the tip presses: the lowest point of the contact (World), how deep, with how much force.
struct TintPress {
  Vector3 point = Vector3::Zero();
  double depth = 0.0, force = 0.0, tip_radius = 0.0;  // m, N, m; depth 0: it does not
};

class OrganTint {
 public:
  // `matter`: of the organ, beside nodules.
  OrganTint(const scene::TriangleMesh& organ, const physics::deformable::Elastic& matter);

  // Veins; where it is pressed the blood is pressed out as far as the contact presses the tissue. Without a shape: veins
  // alone.
  std::shared_ptr<const scene::Tint> living(const scene::Shape* shape, const TintPress& press) const;
  // Von Mises' stress of the surface as the shape stretches it, Hertz's pressure on it where the tip presses
  // (surface_stress.h); `kFullStress` is 1. Without a shape: none.
  static constexpr double kFullStress = 2000.0;  // Pa
  std::shared_ptr<const scene::Tint> stress(const scene::Shape* shape, const TintPress& press) const;
  // Of the newest stress(), the largest; 0 to 1 and beyond.
  static double largest(const scene::Tint& stress);

 private:
  struct Facet {
    std::array<std::uint32_t, 3> corners;
    std::array<double, 4> to_rest;  // from its plane's axes to its two edges, the inverse, by columns
    float share;                    // of area
  };
  double stress_of(const Facet& facet, const scene::Shape& shape, const TintPress& press) const;

  physics::deformable::Elastic matter_;
  std::shared_ptr<const scene::Tint> veins_;  // as drawn where nothing presses
  std::vector<Facet> facets_;
  std::vector<float> area_at_;  // of each vertex
};

}  // namespace palpate::applications::palpation
