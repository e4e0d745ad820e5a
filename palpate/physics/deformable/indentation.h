// A block on a rigid table, pressed on the middle of its top by a spherical tip: force over depth.
//
// The full finite-element solution, for validation and as the reference of faster laws: a block bonded at its
// bottom with free sides, in the frame of box_mesh.h; the tip is a sphere with a shaft above, contact is integrated
// over the displaced surface along the sphere's own normal, per reference area (tip_contact.h). Depth is counted
// from the first touch of the undeformed top. SI. Errors: wrong use for values that make no sense; refused where no
// equilibrium is found. Takes seconds to minutes, one thread; it allocates.
#pragma once

#include <functional>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/physics/deformable/elasticity.h"

namespace palpate::physics::deformable {

struct Indentation {
  Material material;             // inclusions in the block's frame: z downwards from the top is negative
  Vector3 size{0.1, 0.1, 0.05};  // m
  double radius = 0.008;         // m
  Model model = Model::neo_hookean;
  std::vector<double> depths;  // m
  double friction = 0.0;       // Coulomb's coefficient between tip and top
  // Elements across the widest contact's radius; 5 give 1 to 2 % of force.
  double fineness = 5.0;
};

struct IndentationPoint {
  double depth = 0.0;           // m
  double force = 0.0;           // N
  double contact_radius = 0.0;  // m: of the farthest point in contact, before it was displaced
};

// Wrong use where a value makes no sense.
Expected<void> check(const Indentation& indentation);

// In the order of the depths asked for. `progress` hears the share that is done.
Expected<std::vector<IndentationPoint>> solve_indentation(const Indentation& indentation,
                                                          const std::function<void(double)>& progress = {});

}  // namespace palpate::physics::deformable
