// What a soft body is made of, and small-strain elasticity.
//
// Isotropic: Young's modulus and Poisson's ratio, stiffer or softer within inclusions. Pa, metres in the body's
// own frame. Values; pure functions without allocation. Source: Hooke's law as in Timoshenko, Goodier, Theory of
// Elasticity; a deformation gradient F is stored column by column, entry (i, J) at i + 3 J.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/math/so3.h"

namespace palpate::physics::deformable {

using Matrix9 = Eigen::Matrix<double, 9, 9>;

struct Elastic {
  double young = 6000.0;  // Pa
  double poisson = 0.45;
  double shear() const { return young / (2.0 * (1.0 + poisson)); }
  double lame() const { return young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)); }
  double bulk() const { return lame() + 2.0 / 3.0 * shear(); }
  double plane_strain() const { return young / (1.0 - poisson * poisson); }  // E* beneath a rigid tip
};

// An ellipsoid whose matter has `ratio` times the stiffness around it and the same Poisson's ratio.
struct Inclusion {
  Vector3 centre{0.0, 0.0, 0.0};
  Vector3 radii{0.0, 0.0, 0.0};  // along the body's axes
  double ratio = 1.0;
};

// From a place to its surface, to the nearest of many points where it is no ball; negative within a ball.
double distance_to(const Inclusion& inclusion, const Vector3& place);

struct Material {
  Elastic matrix;  // what the inclusions lie in
  std::vector<Inclusion> inclusions;
  // Times the matrix's stiffness. Where inclusions overlap the last one counts.
  double ratio_at(const Vector3& place) const;
};

// Wrong use: a modulus, radius or ratio that is not positive, a Poisson's ratio outside (-1, 0.5).
Expected<void> check(const Material& material);

enum class Model { linear, neo_hookean };

// Energy per reference volume, first Piola-Kirchhoff stress P = dW/dF and dP/dF. The energy is infinite where
// the model does not allow F; stress and tangent mean nothing there.
struct PointResponse {
  double energy = 0.0;  // J/m^3
  Matrix3 stress = Matrix3::Zero();
  Matrix9 tangent = Matrix9::Zero();
};

double linear_energy(double shear, double bulk, const Matrix3& F);
PointResponse linear_response(double shear, double bulk, const Matrix3& F);

}  // namespace palpate::physics::deformable
