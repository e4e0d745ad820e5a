// Neo-Hookean matter: large deformation, compressible as its Poisson's ratio says.
//
//   W = shear/2 (J^(-2/3) I1 - 3) + bulk/2 (J - 1)^2,   J = det F,   I1 = tr F^T F
// which is Hooke's law for small strains. Pa. Pure functions without allocation. Where J <= 0 the energy is
// infinite: no state of matter. Source: Bonet, Wood, Nonlinear Continuum Mechanics for Finite Element Analysis.
#pragma once

#include "palpate/physics/deformable/elasticity.h"

namespace palpate::physics::deformable {

double neo_hookean_energy(double shear, double bulk, const Matrix3& F);
PointResponse neo_hookean_response(double shear, double bulk, const Matrix3& F);

}  // namespace palpate::physics::deformable
