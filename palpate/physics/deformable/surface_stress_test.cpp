// Stress of a surface beside the energy's own, beside rubber's closed form and beside Hooke's law.
#include "palpate/physics/deformable/surface_stress.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "palpate/physics/deformable/hyperelastic.h"

namespace palpate::physics::deformable {
namespace {

Eigen::Matrix2d stretched(double along, double across, double turned = 0.0) {
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(turned).toRotationMatrix();
  return turn * Eigen::Vector2d(along * along, across * across).asDiagonal() * turn.transpose();
}

// One way, what cannot be compressed: shear (stretch^2 - 1/stretch) (Treloar 1944).
TEST(SurfaceStress, OfAStripIsThatOfRubber) {
  const Elastic rubber{6000.0, 0.499999};
  for (const double stretch : {0.7, 0.9, 1.1, 1.5, 2.0}) {
    const double expected = rubber.shear() * std::abs(stretch * stretch - 1.0 / stretch);
    EXPECT_NEAR(surface_von_mises(rubber, stretched(stretch, 1.0 / std::sqrt(stretch), 0.4)), expected,
                1e-4 * expected);
  }
}

// Small strains e and f in the plane: Hooke's plane stress.
TEST(SurfaceStress, IsHookesForSmallStrains) {
  const Elastic matter{6000.0, 0.3};
  for (const auto& [e, f] : {std::pair{1e-5, 0.0}, std::pair{1e-5, 1e-5}, std::pair{1e-5, -2e-5}}) {
    const double share = matter.young / (1.0 - 0.3 * 0.3);
    const double one = share * (e + 0.3 * f), other = share * (f + 0.3 * e);
    const double expected = std::sqrt(one * one - one * other + other * other);
    EXPECT_NEAR(surface_von_mises(matter, stretched(1.0 + e, 1.0 + f, 1.1)), expected, 1e-4 * expected);
  }
}

// Pressed on without being stretched in its plane: the stretch along the normal is looked for by halving, its stress taken
// of the energy's derivative.
TEST(SurfaceStress, UnderAPressureIsTheEnergysOwn) {
  const Elastic matter{6000.0, 0.45};
  for (const double pressure : {0.0, 500.0, 4000.0, 20000.0})
    for (const auto& plane : {std::pair{1.0, 1.0}, std::pair{1.3, 0.8}, std::pair{0.6, 0.9}}) {
      const auto cauchy = [&](double normal) -> Matrix3 {
        const Matrix3 F = Vector3(plane.first, plane.second, normal).asDiagonal();
        return neo_hookean_response(matter.shear(), matter.bulk(), F).stress * F.transpose() /
               F.determinant();
      };
      double low = 0.05, high = 20.0;
      for (int i = 0; i < 80; ++i) {
        const double middle = 0.5 * (low + high);
        (cauchy(middle)(2, 2) < -pressure ? low : high) = middle;
      }
      const Matrix3 stress = cauchy(low);
      ASSERT_NEAR(stress(2, 2), -pressure, 1e-6 * matter.young);
      const Matrix3 deviator = stress - stress.trace() / 3.0 * Matrix3::Identity();
      const double expected = std::sqrt(1.5) * deviator.norm();
      EXPECT_NEAR(surface_von_mises(matter, stretched(plane.first, plane.second, 0.3), pressure), expected,
                  1e-6 * matter.young);
    }
}

TEST(SurfaceStress, OfNothingIsNone) {
  const Elastic matter;
  EXPECT_EQ(surface_von_mises(matter, Eigen::Matrix2d::Zero()), 0.0);
  EXPECT_EQ(surface_von_mises(matter, Eigen::Matrix2d::Constant(std::nan(""))), 0.0);
  EXPECT_NEAR(surface_von_mises(matter, Eigen::Matrix2d::Identity()), 0.0, 1e-7);
}

}  // namespace
}  // namespace palpate::physics::deformable
