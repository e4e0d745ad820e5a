// Two tips on one soft body at once: each sinks in less deep where the other presses, because the other has dented
// the surface under it.
//
//   d_i = delta_i + C F_j(delta_j),  E = W_1(delta_1) + W_2(delta_2) + C F_1 F_2,  F_i = dW_i / d delta_i
// d_i is the depth of tip i by its place, delta_i what is left of it for its own contact, C = C_12 = C_21 how far the
// surface gives way under one contact for each newton on the other. Forces on the tips are the exact gradient of E
// by both places, so that pressing at two places gives out no work either.
// Superposition of small dents: where the footprints overlap it fails, and C is that of two touching ones at most.
// Body's frame, SI. Const, any thread; no allocation, kSteps of Newton's method whatever comes.
#pragma once

#include "palpate/math/so3.h"
#include "palpate/physics/tissue/tip_field.h"

namespace palpate::physics::tissue {

// C_12 of two places and its gradient by the first one; by the second one it is the opposite.
struct MutualCompliance {
  double value = 0.0;                  // m/N
  Vector3 gradient = Vector3::Zero();  // 1/N
};

// Of a half-space (Boussinesq): (1 - nu^2) / (pi E r), with r = sqrt(distance^2 + closest^2), so that it stays bounded.
MutualCompliance half_space_compliance(const Vector3& first, const Vector3& second, double young,
                                       double poisson, double closest);

struct TwoForces {
  Vector3 first = Vector3::Zero(), second = Vector3::Zero();  // N, on the tips
  double energy = 0.0;                                        // J
  double first_depth = 0.0, second_depth = 0.0;               // m, what is left for each contact's own
};

// Of two tips at places `first` and `second`, each in its field.
TwoForces two_contacts(const TipField& field_1, const Vector3& first, const TipField& field_2,
                       const Vector3& second, const MutualCompliance& mutual);

}  // namespace palpate::physics::tissue
