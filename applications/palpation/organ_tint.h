// Colours of the organ's surface beside its own: veins under the capsule, paler where it is pressed; or how far it is
// stretched.
//
// A share for each vertex of the organ (scene::Tint). Vertices and shapes: the organ's, in the frame Body and in World.
// One thread.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "palpate/scene/draw_item.h"

namespace palpate::applications::palpation {

class OrganTint {
 public:
  explicit OrganTint(const scene::TriangleMesh& organ);

  // Veins; around `point` (World) the blood is pressed out as far as the contact of a sphere of `tip_radius`, `depth`
  // deep, presses the tissue. Without a shape, or not pressed (depth 0): veins alone.
  std::shared_ptr<const scene::Tint> living(const scene::Shape* shape, const Vector3& point, double depth,
                                            double tip_radius) const;
  // How much longer or shorter the surface's edges at each place are than at rest, their mean: `kFullStrain` is 1.
  // Without a shape: none is.
  static constexpr double kFullStrain = 0.15;
  std::shared_ptr<const scene::Tint> strain(const scene::Shape* shape) const;
  // Of the newest strain(), the largest; 0 to 1 and beyond.
  static double largest(const scene::Tint& strain);

 private:
  struct Edge {
    std::array<std::uint32_t, 2> ends;
    float length;  // m, at rest
  };
  std::shared_ptr<const scene::Tint> veins_;  // as drawn where nothing presses
  std::vector<Edge> edges_;
  std::vector<float> edges_at_;  // of each vertex, how many
};

}  // namespace palpate::applications::palpation
