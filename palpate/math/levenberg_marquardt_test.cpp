#include "palpate/math/levenberg_marquardt.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate::inline math {
namespace {

// A problem from its residuals and their derivatives.
template <typename F>
LeastSquaresProblem from_residuals(F evaluate) {
  return {[evaluate](const Eigen::VectorXd& x) {
            Eigen::VectorXd r;
            Eigen::MatrixXd J;
            evaluate(x, r, J);
            return r.squaredNorm();
          },
          [evaluate](const Eigen::VectorXd& x, NormalEquations& at) {
            Eigen::VectorXd r;
            Eigen::MatrixXd J;
            evaluate(x, r, J);
            at.JtJ = J.transpose() * J;
            at.Jtr = J.transpose() * r;
            at.cost = r.squaredNorm();
          }};
}

// Rosenbrock's valley (1960), minimum 0 at (1, 1); `unit` measures its second unknown.
LeastSquaresProblem valley(double unit) {
  return from_residuals([unit](const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd& J) {
    const double y = unit * x[1];
    r = Eigen::Vector2d(10.0 * (y - x[0] * x[0]), 1.0 - x[0]);
    J.resize(2, 2);
    J << -20.0 * x[0], 10.0 * unit, -1.0, 0.0;
  });
}

TEST(LevenbergMarquardt, FollowsRosenbrocksValleyToItsEnd) {
  const auto result = least_squares_from(Eigen::Vector2d(-1.2, 1.0), valley(1.0));
  EXPECT_TRUE(result.converged);
  EXPECT_NEAR(result.x[0], 1.0, 1e-10);
  EXPECT_NEAR(result.x[1], 1.0, 1e-10);
}

TEST(LevenbergMarquardt, TakesTheSamePathInOtherUnits) {
  const auto metres = least_squares_from(Eigen::Vector2d(-1.2, 1.0), valley(1.0));
  const auto millimetres = least_squares_from(Eigen::Vector2d(-1.2, 1000.0), valley(1e-3));
  EXPECT_EQ(metres.iterations, millimetres.iterations);
  EXPECT_NEAR(millimetres.x[1], 1000.0 * metres.x[1], 1e-7);
}

// With a residual left over: exponential decay y = a exp(-b t) against five values; the minimum was checked
// by the gradient, not by another program.
TEST(LevenbergMarquardt, EndsWhereTheGradientVanishes) {
  const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(5, 0.0, 2.0);
  const Eigen::VectorXd y = (Eigen::VectorXd(5) << 2.1, 1.2, 0.65, 0.5, 0.2).finished();
  const auto problem = from_residuals([&](const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd& J) {
    const Eigen::VectorXd e = (-x[1] * t).array().exp();
    r = x[0] * e - y;
    J.resize(5, 2);
    J << e, -x[0] * t.cwiseProduct(e);
  });
  const auto result = least_squares_from(Eigen::Vector2d(1.0, 0.0), problem);
  EXPECT_TRUE(result.converged);
  NormalEquations at{Eigen::MatrixXd::Zero(2, 2), Eigen::VectorXd::Zero(2)};
  problem.linearise(result.x, at);
  EXPECT_LT(at.Jtr.norm(), 1e-8);
  EXPECT_GT(at.cost, 0.01);
}

TEST(LevenbergMarquardt, AStepIntoNonsenseIsNotTaken) {
  // sqrt(x) - 2 from x = 1: a full Gauss-Newton step stays positive, from 30 it would go below zero
  const auto problem = from_residuals([](const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd& J) {
    r = Eigen::VectorXd::Constant(1, std::sqrt(x[0]) - 2.0);
    J = Eigen::MatrixXd::Constant(1, 1, 0.5 / std::sqrt(x[0]));
  });
  const auto result = least_squares_from(Eigen::VectorXd::Constant(1, 30.0), problem);
  EXPECT_TRUE(result.converged);
  EXPECT_NEAR(result.x[0], 4.0, 1e-8);
}

TEST(LevenbergMarquardt, AnUnknownThatNothingDependsOnStaysWhereItWas) {
  const auto problem = from_residuals([](const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd& J) {
    r = Eigen::VectorXd::Constant(1, x[0] * x[0] - 9.0);
    J.setZero(1, 2);
    J(0, 0) = 2.0 * x[0];
  });
  const auto result = least_squares_from(Eigen::Vector2d(1.0, 0.7), problem);
  EXPECT_NEAR(result.x[0], 3.0, 1e-10);
  EXPECT_EQ(result.x[1], 0.7);
}

TEST(LevenbergMarquardt, StopsAtTheLimitAndSaysSo) {
  const auto result = least_squares_from(Eigen::Vector2d(-1.2, 1.0), valley(1.0), {.most_iterations = 3});
  EXPECT_EQ(result.iterations, 3);
  EXPECT_FALSE(result.converged);
}

}  // namespace
}  // namespace palpate::inline math
