#include "palpate/physics/deformable/elasticity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace palpate::physics::deformable {
namespace {

Matrix3 small_strain(const Matrix3& F) { return 0.5 * (F + F.transpose()) - Matrix3::Identity(); }

}  // namespace

double distance_to(const Inclusion& inclusion, const Vector3& place) {
  const Vector3& radii = inclusion.radii;
  if (radii.minCoeff() == radii.maxCoeff()) return (place - inclusion.centre).norm() - radii.x();
  constexpr int kSteps = 64;
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j < 2 * kSteps; ++j) {
      const double theta = std::numbers::pi * i / kSteps, phi = std::numbers::pi * j / kSteps;
      const Vector3 way(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
      nearest = std::min(nearest, (inclusion.centre + radii.cwiseProduct(way) - place).norm());
    }
  return nearest;
}

double Material::ratio_at(const Vector3& place) const {
  double ratio = 1.0;
  for (const auto& inclusion : inclusions)
    if ((place - inclusion.centre).cwiseQuotient(inclusion.radii).squaredNorm() <= 1.0)
      ratio = inclusion.ratio;
  return ratio;
}

Expected<void> check(const Material& material) {
  const auto& m = material.matrix;
  if (!(m.young > 0.0))
    return wrong_use("material: Young's modulus is {} Pa; a positive one is expected", m.young);
  if (!(m.poisson > -1.0 && m.poisson < 0.5))
    return wrong_use("material: Poisson's ratio is {}; more than -1 and less than 0.5 is expected",
                     m.poisson);
  for (const auto& inclusion : material.inclusions) {
    if (!(inclusion.radii.minCoeff() > 0.0 && inclusion.radii.allFinite() && inclusion.centre.allFinite()))
      return wrong_use("material: an inclusion's radius is {} m; a positive one is expected",
                       inclusion.radii.minCoeff());
    if (!(inclusion.ratio > 0.0))
      return wrong_use("material: an inclusion's ratio is {}; a positive one is expected", inclusion.ratio);
  }
  return {};
}

double linear_energy(double shear, double bulk, const Matrix3& F) {
  const Matrix3 strain = small_strain(F);
  const double trace = strain.trace();
  return 0.5 * (bulk - 2.0 / 3.0 * shear) * trace * trace + shear * strain.squaredNorm();
}

PointResponse linear_response(double shear, double bulk, const Matrix3& F) {
  PointResponse response;
  const Matrix3 strain = small_strain(F);
  const double lame = bulk - 2.0 / 3.0 * shear;
  response.energy = linear_energy(shear, bulk, F);
  response.stress = lame * strain.trace() * Matrix3::Identity() + 2.0 * shear * strain;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      response.tangent(i + 3 * i, j + 3 * j) += lame;
      response.tangent(i + 3 * j, i + 3 * j) += shear;
      response.tangent(i + 3 * j, j + 3 * i) += shear;
    }
  return response;
}

}  // namespace palpate::physics::deformable
