#include "palpate/physics/deformable/sparse_solver.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <thread>
#include <vector>

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

// A square of springs: its elimination has dense blocks, for which a library of dense algebra is called.
SymmetricMatrix square_of_springs(int side) {
  SymmetricMatrix matrix;
  matrix.size = side * side;
  matrix.starts.assign(1, 0);
  const auto add = [&](int row, double value) {
    matrix.rows.push_back(row);
    matrix.values.push_back(value);
  };
  for (int column = 0; column < matrix.size; ++column) {
    add(column, 4.0);
    if ((column + 1) % side != 0) add(column + 1, -1.0);
    if (column + side < matrix.size) add(column + side, -1.0);
    matrix.starts.push_back(static_cast<int>(matrix.rows.size()));
  }
  return matrix;
}

TEST(SparseSolver, InSeveralThreadsItSolvesAsInOne) {
  const auto matrix = square_of_springs(60);
  const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(matrix.size, -1.0, 2.0);
  const auto solved = [&] {
    Eigen::VectorXd x = right;
    auto factor = SparseFactor::analyse(matrix);
    const bool good = factor && factor->factorise(matrix) && factor->solve(x);
    return good ? x : Eigen::VectorXd();
  };
  const Eigen::VectorXd alone = solved();
  ASSERT_LT((matrix.times(alone) - right).norm(), 1e-9 * right.norm());
  std::vector<std::vector<Eigen::VectorXd>> found(4);
  std::vector<std::thread> threads;
  for (auto& of_thread : found)
    threads.emplace_back([&] {
      for (int i = 0; i < 10; ++i) of_thread.push_back(solved());
    });
  for (auto& thread : threads) thread.join();
  for (const auto& of_thread : found)
    for (const auto& x : of_thread) EXPECT_EQ(x, alone);
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

Eigen::MatrixXd dense(const SymmetricMatrix& matrix) {
  Eigen::MatrixXd all(matrix.size, matrix.size);
  for (int k = 0; k < matrix.size; ++k) all.col(k) = matrix.times(Eigen::VectorXd::Unit(matrix.size, k));
  return all;
}

TEST(SparseSolver, EquationsThatAreKeptAreCondensedAsByDenseInversion) {
  constexpr int kSize = 60;
  const auto matrix = row_of_springs(kSize, 0.3);
  const std::vector<int> kept{41, 7, 8, 40, 59};  // in an order of their own
  auto factor = SparseFactor::analyse(matrix, kept);
  ASSERT_TRUE(factor) << factor.error().message;
  EXPECT_EQ(factor->condensed().size(), 0);
  ASSERT_TRUE(factor->factorise(row_of_springs(kSize, 1.0)));
  ASSERT_TRUE(factor->factorise(matrix)) << "another of the pattern";
  const Eigen::MatrixXd inverse = dense(matrix).inverse();
  const Eigen::MatrixXd compliance = inverse(kept, kept);
  EXPECT_LT((factor->condensed() * compliance - Eigen::MatrixXd::Identity(5, 5)).norm(), 1e-12);

  const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(kSize, -1.0, 2.0), x = inverse * right;
  const auto left = factor->condense(right);
  ASSERT_TRUE(left) << left.error().message;
  EXPECT_LT((factor->condensed() * x(kept) - *left).norm(), 1e-12);
  const auto whole = factor->expand(x(kept));
  ASSERT_TRUE(whole) << whole.error().message;
  EXPECT_LT((*whole - x).norm(), 1e-12);

  // Other values of the kept ones: the eliminated ones are in equilibrium all the same.
  const Eigen::VectorXd held = Eigen::VectorXd::LinSpaced(5, 0.1, 0.5);
  ASSERT_TRUE(factor->condense(right));
  const auto moved = factor->expand(held);
  ASSERT_TRUE(moved);
  EXPECT_EQ((*moved)(kept), held);
  Eigen::VectorXd rest = matrix.times(*moved) - right;
  rest(kept).setZero();
  EXPECT_LT(rest.norm(), 1e-12);
}

TEST(SparseSolver, WhatIsKeptIsNotSolvedAndOnlyWhatIsKeptIsCondensed) {
  const auto matrix = row_of_springs(20, 0.3);
  EXPECT_FALSE(SparseFactor::analyse(matrix, {3, 20}));
  EXPECT_FALSE(SparseFactor::analyse(matrix, {-1, 3}));
  auto factor = SparseFactor::analyse(matrix, {3});
  Eigen::VectorXd x = Eigen::VectorXd::Ones(20);
  EXPECT_FALSE(factor->condense(x)) << "before it is factorised";
  ASSERT_TRUE(factor->factorise(matrix));
  EXPECT_FALSE(factor->solve(x));
  EXPECT_FALSE(factor->expand(Eigen::VectorXd::Ones(1))) << "before anything is condensed";
  EXPECT_FALSE(factor->condense(Eigen::VectorXd::Ones(19)));
  ASSERT_TRUE(factor->condense(x));
  EXPECT_FALSE(factor->expand(Eigen::VectorXd::Ones(2)));
  auto whole = SparseFactor::analyse(matrix);
  ASSERT_TRUE(whole->factorise(matrix));
  EXPECT_FALSE(whole->condense(x));
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
