#include "palpate/physics/deformable/hyperelastic.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace palpate::physics::deformable {

double neo_hookean_energy(double shear, double bulk, const Matrix3& F) {
  const double J = F.determinant();
  if (!(J > 0.0)) return std::numeric_limits<double>::infinity();
  return 0.5 * shear * (std::pow(J, -2.0 / 3.0) * F.squaredNorm() - 3.0) + 0.5 * bulk * (J - 1.0) * (J - 1.0);
}

PointResponse neo_hookean_response(double shear, double bulk, const Matrix3& F) {
  PointResponse response;
  response.energy = neo_hookean_energy(shear, bulk, F);
  if (!std::isfinite(response.energy)) return response;
  const double J = F.determinant(), first = F.squaredNorm(), scaled = shear * std::pow(J, -2.0 / 3.0);
  const Matrix3 G = F.inverse().transpose();  // dJ/dF = J G
  const double along_G = bulk * (J - 1.0) * J - scaled * first / 3.0;
  response.stress = scaled * F + along_G * G;
  using Vector9 = Eigen::Matrix<double, 9, 1>;
  const Vector9 f = Eigen::Map<const Vector9>(F.data()), g = Eigen::Map<const Vector9>(G.data());
  Matrix9& A = response.tangent;
  A = (2.0 / 9.0 * scaled * first + bulk * (2.0 * J - 1.0) * J) * g * g.transpose();
  A -= 2.0 / 3.0 * scaled * (f * g.transpose() + g * f.transpose());
  A.diagonal().array() += scaled;
  for (int L = 0; L < 3; ++L)  // dG = -G dF^T G
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i) A(i + 3 * j, k + 3 * L) -= along_G * G(i, L) * G(k, j);
  return response;
}

}  // namespace palpate::physics::deformable
