// What is known in closed form of a rigid sphere on an elastic half-space and on a layer that is bonded to a rigid
// base.
//
// SI. Pure functions without allocation. Sources: Hertz (1882); Dimitriadis et al., Biophys. J. 82 (2002) 2798,
// equation 12, for a bonded layer.
#pragma once

#include "palpate/physics/deformable/elasticity.h"

namespace palpate::physics::deformable {

double hertz_force(const Elastic& matter, double radius, double depth);
double hertz_contact_radius(double radius, double depth);
// Force on a bonded layer over Hertz's force.
double bonded_layer_factor(double poisson, double radius, double depth, double thickness);

}  // namespace palpate::physics::deformable
