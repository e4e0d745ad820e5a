// Stress in the surface of a neo-Hookean body, from how that is stretched in its own plane and pressed on.
//
// What acts across the surface is known: `pressure` where something presses, nothing elsewhere. So the stretch along the
// normal is the one that answers to it, and the stress follows. Pa. Pure, without allocation. Source: the energy of
// hyperelastic.h; plane stress as in Bonet, Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, section 6.6.
#pragma once

#include <Eigen/Core>

#include "palpate/physics/deformable/elasticity.h"

namespace palpate::physics::deformable {

// Von Mises' equivalent of the Cauchy stress. `C`: squared stretches in the plane (right Cauchy-Green), in any axes that
// are at right angles at rest; 1 at rest. 0 where C is none (not positive definite).
double surface_von_mises(const Elastic& matter, const Eigen::Matrix2d& C, double pressure = 0.0);

}  // namespace palpate::physics::deformable
