#include "palpate/math/linear_algebra.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>

#include "palpate/core/random.h"

namespace palpate::inline math {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_matrix(Random& random, Eigen::Index rows, Eigen::Index columns) {
  MatrixXd A(rows, columns);
  for (Eigen::Index j = 0; j < columns; ++j)
    for (Eigen::Index i = 0; i < rows; ++i) A(i, j) = random.normal();
  return A;
}

// Tolerances: rounding of well-conditioned 7 x 7 problems, 1e-16 times a condition of a thousand.
constexpr double kRounding = 1e-11;

TEST(LinearAlgebra, SymmetricSystemsAreSolvedAndInverted) {
  Random random(1, "linear algebra");
  const MatrixXd J = random_matrix(random, 20, 7), A = J.transpose() * J;
  const VectorXd x = random_matrix(random, 7, 1);
  EXPECT_LT((solve_symmetric(A, A * x) - x).norm(), kRounding);
  EXPECT_LT((inverse_symmetric(A) * A - MatrixXd::Identity(7, 7)).norm(), kRounding);
  EXPECT_LT((pseudo_inverse_symmetric(A) - inverse_symmetric(A)).norm(), kRounding);
}

TEST(LinearAlgebra, PseudoInverseOfASingularMatrixMeetsPenroseConditions) {
  Random random(2, "linear algebra");
  const MatrixXd J = random_matrix(random, 2, 5), A = J.transpose() * J, P = pseudo_inverse_symmetric(A);
  EXPECT_LT((A * P * A - A).norm(), kRounding);
  EXPECT_LT((P * A * P - P).norm(), kRounding);
}

TEST(LinearAlgebra, CovarianceIsTheInverseWhateverTheUnits) {
  Random random(4, "linear algebra");
  const MatrixXd J = random_matrix(random, 20, 6), A = J.transpose() * J;
  const MatrixXd K = random_matrix(random, 9, 6), M = K.transpose() * K;
  const VectorXd units = (VectorXd(6) << 1e-9, 1e-3, 1.0, 1e3, 1e6, 1e9).finished();
  const MatrixXd Au = units.asDiagonal() * A * units.asDiagonal(),
                 Mu = units.asDiagonal() * M * units.asDiagonal();
  const MatrixXd C = units.asDiagonal() * covariance_from_information(Au) * units.asDiagonal();
  EXPECT_LT((C - inverse_symmetric(A)).norm(), kRounding);
  const MatrixXd S = units.asDiagonal() * sandwich_covariance(Au, Mu) * units.asDiagonal();
  EXPECT_LT((S - inverse_symmetric(A) * M * inverse_symmetric(A)).norm(), kRounding);
}

TEST(LinearAlgebra, WhatIsNotKnownHasAnEnormousVarianceAndNeverANegativeOne) {
  Random random(5, "linear algebra");
  for (int run = 0; run < 200; ++run) {
    MatrixXd J = random_matrix(random, 12, 5);
    J.col(3) = J.col(1) + J.col(2);  // their difference cannot be told
    J.col(4).setZero();              // held fixed
    const MatrixXd C = covariance_from_information(J.transpose() * J);
    EXPECT_GE(C.diagonal().minCoeff(), 0.0);
    EXPECT_LT(C(0, 0), 10.0);
    for (const Eigen::Index k : {1, 2, 3}) EXPECT_GT(C(k, k), 1e10);
    EXPECT_EQ(C(4, 4), 0.0);
    EXPECT_GE(sandwich_covariance(J.transpose() * J, J.transpose() * J).diagonal().minCoeff(), 0.0);
  }
}

TEST(LinearAlgebra, EigenvaluesRebuildTheirMatrix) {
  Random random(3, "linear algebra");
  const MatrixXd B = random_matrix(random, 9, 5), A = B.transpose() * B;
  const auto eigen = symmetric_eigen(A);
  EXPECT_LT((eigen.vectors * eigen.values.asDiagonal() * eigen.vectors.transpose() - A).norm(), kRounding);
  EXPECT_LE(eigen.values[0], eigen.values[4]);
  EXPECT_LT((symmetric_eigenvalues(A) - eigen.values).norm(), kRounding);
}

TEST(LinearAlgebra, LeastSquaresLeavesAResidualAtRightAnglesToTheColumns) {
  Random random(4, "linear algebra");
  const MatrixXd A = random_matrix(random, 12, 4), B = random_matrix(random, 12, 3);
  EXPECT_LT((A.transpose() * (A * least_squares_columns(A, B) - B)).norm(), kRounding);
}

TEST(LinearAlgebra, CholeskySaysWhenThereIsNone) {
  MatrixXd L;
  Eigen::Matrix2d A;
  A << 4.0, 2.0, 2.0, 3.0;
  ASSERT_TRUE(lower_cholesky(A, L));
  EXPECT_NEAR(L(0, 0), 2.0, 1e-15);
  EXPECT_NEAR(L(1, 0), 1.0, 1e-15);
  EXPECT_NEAR(L(1, 1), std::sqrt(2.0), 1e-15);
  EXPECT_EQ(L(0, 1), 0.0);
  A(1, 1) = 0.5;
  EXPECT_FALSE(lower_cholesky(A, L));
}

TEST(LinearAlgebra, WhiteningMakesTheCovarianceOne) {
  Random random(6, "linear algebra");
  const Eigen::Matrix3d B = random_matrix(random, 3, 3), C = 1e-8 * B * B.transpose();
  Eigen::Matrix3d W;
  ASSERT_TRUE(whitening(C, W));
  EXPECT_LT((W * C * W.transpose() - Eigen::Matrix3d::Identity()).norm(), kRounding);
  EXPECT_FALSE(whitening(-C, W));
}

TEST(LinearAlgebra, NearestRotationFindsTheTurnOfPairsAndNeverMirrors) {
  Random random(5, "linear algebra");
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, -2, 3).normalized()).matrix();
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero(), mirrored = M;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector3d a(random.normal(), random.normal(), random.normal());
    M += turn * a * a.transpose();
    mirrored += -(turn * a) * a.transpose();
  }
  EXPECT_LT((nearest_rotation(M).rotation - turn).norm(), kRounding);
  EXPECT_FALSE(nearest_rotation(M).mirrored);
  EXPECT_TRUE(nearest_rotation(mirrored).mirrored);
  EXPECT_NEAR(nearest_rotation(mirrored).rotation.determinant(), 1.0, 1e-12);
}

}  // namespace
}  // namespace palpate::inline math
