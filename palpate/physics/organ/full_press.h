// A tip pressed into an organ at one place, by the full neo-Hookean solution: what the tick is compared with.
//
// The organ's mesh is made finer under the tip and about the nodules near it, and follows the surface there. The tip is
// pushed along the place's normal, without friction. SI, the body's frame. Seconds to minutes, one thread; it allocates.
// Refused: what organ_mesh() refuses, no equilibrium, no memory.
#pragma once

#include <vector>

#include "palpate/physics/deformable/surface_load.h"
#include "palpate/physics/organ/prepared_organ.h"

namespace palpate::physics::organ {

struct FullState {
  double depth = 0.0;               // m
  Vector3 force = Vector3::Zero();  // N, on the tip
  double contact_radius = 0.0;      // m
};

struct FullPress {
  std::vector<FullState> states;
  std::size_t nodes = 0;
};

// Rising depths. `fineness`: elements across the contact's radius at the least depth.
Expected<FullPress> full_press(const scene::TriangleMesh& surface, const OrganSettings& settings,
                               const deformable::SurfaceSite& site, const std::vector<double>& depths,
                               double fineness = 1.0);

}  // namespace palpate::physics::organ
