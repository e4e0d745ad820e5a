#include "palpate/physics/deformable/sparse_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace palpate::physics::deformable {
namespace {

// The discrete Laplacian of a row of points, plus `shift` on its diagonal: eigenvalues 2 - 2 cos(k pi / (n + 1)).
SymmetricMatrix row_of_springs(int size, double shift) {
  SymmetricMatrix matrix;
  matrix.size = size;
  matrix.starts.assign(1, 0);
  for (int column = 0; column < size; ++column) {
    matrix.rows.push_back(column);
    matrix.values.push_back(2.0 + shift);
    if (column + 1 < size) {
      matrix.rows.push_back(column + 1);
      matrix.values.push_back(-1.0);
    }
    matrix.starts.push_back(static_cast<int>(matrix.rows.size()));
  }
  return matrix;
}

TEST(SparseSolver, EigenvectorsComeBackScaledByTheirEigenvalue) {
  constexpr int kSize = 500;
  const auto matrix = row_of_springs(kSize, 0.0);
  auto factor = SparseFactor::analyse(matrix);
  ASSERT_TRUE(factor) << factor.error().message;
  const auto done = factor->factorise(matrix);
  ASSERT_TRUE(done) << done.error().message;
  Eigen::MatrixXd columns(kSize, 40);
  for (int k = 0; k < 40; ++k)
    for (int i = 0; i < kSize; ++i)
      columns(i, k) = std::sin((k + 1.0) * (i + 1.0) * std::numbers::pi / (kSize + 1.0));
  const Eigen::MatrixXd before = columns;
  ASSERT_TRUE(factor->solve(columns));
  for (int k = 0; k < 40; ++k) {
    const double value = 2.0 - 2.0 * std::cos((k + 1.0) * std::numbers::pi / (kSize + 1.0));
    EXPECT_LT((columns.col(k) * value - before.col(k)).norm(), 1e-9 * before.col(k).norm()) << k;
    EXPECT_LT((matrix.times(before.col(k)) - value * before.col(k)).norm(), 1e-12 * before.col(k).norm())
        << k;
  }
  EXPECT_GE(factor->entries(), 2 * kSize - 1);
}

TEST(SparseSolver, AnotherMatrixOfThePatternIsFactorisedAnew) {
  const auto first = row_of_springs(50, 0.0), second = row_of_springs(50, 3.0);
  auto factor = SparseFactor::analyse(first);
  ASSERT_TRUE(factor && factor->factorise(first) && factor->factorise(second));
  const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(50, 1.0, 2.0);
  Eigen::VectorXd x = right;
  ASSERT_TRUE(factor->solve(x));
  EXPECT_LT((second.times(x) - right).norm(), 1e-12);
}

TEST(SparseSolver, WhatIsNotPositiveDefiniteIsRefused) {
  const auto pattern = row_of_springs(50, 0.0);
  auto factor = SparseFactor::analyse(pattern);
  ASSERT_TRUE(factor);
  Eigen::VectorXd x = Eigen::VectorXd::Ones(50);
  EXPECT_FALSE(factor->solve(x)) << "before it is factorised";
  ASSERT_TRUE(factor->factorise(pattern));
  EXPECT_FALSE(factor->factorise(row_of_springs(50, -1.0))) << "indefinite";
  EXPECT_FALSE(factor->solve(x)) << "no factor is left";
  auto zero = pattern;
  zero.values.assign(zero.values.size(), 0.0);
  EXPECT_FALSE(factor->factorise(zero)) << "singular";
  EXPECT_TRUE(factor->factorise(pattern)) << "and it is used again";
  auto wrong = pattern;
  wrong.rows[3] = 50;
  EXPECT_FALSE(SparseFactor::analyse(wrong)) << "a row beyond the last";
}

}  // namespace
}  // namespace palpate::physics::deformable
