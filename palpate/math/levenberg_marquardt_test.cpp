#include "palpate/math/levenberg_marquardt.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/math/pose_step.h"

namespace palpate::inline math {
namespace {

using Equations = NormalEquations<Eigen::Dynamic>;

// A problem from its residuals and their derivatives.
template <typename F>
auto from_residuals(F evaluate) {
  return [evaluate](const Eigen::VectorXd& x, Equations* at) {
    Eigen::VectorXd r;
    Eigen::MatrixXd J;
    evaluate(x, r, J);
    if (at) at->add(J, r);
    return r.squaredNorm();
  };
}

struct Found : LeastSquaresResult {
  Eigen::VectorXd x;
};
template <typename Evaluate>
Found from(Eigen::VectorXd x, const Evaluate& evaluate, const LeastSquaresOptions& options = {}) {
  const auto result = minimise(x, evaluate, options);
  return {result, x};
}

// Rosenbrock's valley (1960), minimum 0 at (1, 1); `unit` measures its second unknown.
auto valley(double unit) {
  return from_residuals([unit](const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd& J) {
    const double y = unit * x[1];
    r = Eigen::Vector2d(10.0 * (y - x[0] * x[0]), 1.0 - x[0]);
    J.resize(2, 2);
    J << -20.0 * x[0], 10.0 * unit, -1.0, 0.0;
  });
}

TEST(LevenbergMarquardt, FollowsRosenbrocksValleyToItsEnd) {
  const auto result = from(Eigen::Vector2d(-1.2, 1.0), valley(1.0));
  EXPECT_TRUE(result.converged);
  EXPECT_NEAR(result.x[0], 1.0, 1e-10);
  EXPECT_NEAR(result.x[1], 1.0, 1e-10);
}

TEST(LevenbergMarquardt, TakesTheSamePathInOtherUnits) {
  const auto metres = from(Eigen::Vector2d(-1.2, 1.0), valley(1.0));
  const auto millimetres = from(Eigen::Vector2d(-1.2, 1000.0), valley(1e-3));
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
  const auto result = from(Eigen::Vector2d(1.0, 0.0), problem);
  EXPECT_TRUE(result.converged);
  Equations at(2);
  EXPECT_GT(problem(result.x, &at), 0.01);
  EXPECT_LT(at.Jtr.norm(), 1e-8);
}

// atan(x) from 2: Gauss-Newton's steps lead to -3.5, 13.9, -279 (Dennis, Schnabel 1983, section 5.4).
TEST(LevenbergMarquardt, NoStepThatRaisesTheCostIsTaken) {
  double tried = 0.0, highest = 0.0;
  Eigen::VectorXd x = Eigen::VectorXd::Constant(1, 2.0);
  const auto evaluate = [&](const Eigen::VectorXd& at, Equations* equations) {
    const Eigen::VectorXd r = at.array().atan();
    if (equations) equations->add(Eigen::MatrixXd::Constant(1, 1, 1.0 / (1.0 + at[0] * at[0])), r);
    tried = std::max(tried, std::abs(at[0]));
    return r.squaredNorm();
  };
  const auto moved = [&](const Eigen::VectorXd& at, const Eigen::VectorXd& step) -> Eigen::VectorXd {
    highest = std::max(highest, std::abs(at[0]));  // steps are made from states that were taken
    return at + step;
  };
  const auto from_zero = [&](const Eigen::VectorXd& at, Equations* equations) {
    if (equations) equations->set_zero(1);
    return evaluate(at, equations);
  };
  EXPECT_TRUE(minimise_with(Equations(1), x, from_zero, moved).converged);
  EXPECT_NEAR(x[0], 0.0, 1e-10);
  EXPECT_GT(tried, 3.0);  // it would have led there
  EXPECT_LE(highest, 2.0);
}

TEST(LevenbergMarquardt, AStepIntoNonsenseIsNotTaken) {
  // sqrt(x) - 2 from x = 1: a full Gauss-Newton step stays positive, from 30 it would go below zero
  const auto problem = from_residuals([](const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd& J) {
    r = Eigen::VectorXd::Constant(1, std::sqrt(x[0]) - 2.0);
    J = Eigen::MatrixXd::Constant(1, 1, 0.5 / std::sqrt(x[0]));
  });
  const auto result = from(Eigen::VectorXd::Constant(1, 30.0), problem);
  EXPECT_TRUE(result.converged);
  EXPECT_NEAR(result.x[0], 4.0, 1e-8);
}

TEST(LevenbergMarquardt, AnUnknownThatNothingDependsOnStaysWhereItWas) {
  const auto problem = from_residuals([](const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd& J) {
    r = Eigen::VectorXd::Constant(1, x[0] * x[0] - 9.0);
    J.setZero(1, 2);
    J(0, 0) = 2.0 * x[0];
  });
  const auto result = from(Eigen::Vector2d(1.0, 0.7), problem);
  EXPECT_NEAR(result.x[0], 3.0, 1e-10);
  EXPECT_EQ(result.x[1], 0.7);
}

TEST(LevenbergMarquardt, StopsAtTheLimitAndSaysSo) {
  const auto result = from(Eigen::Vector2d(-1.2, 1.0), valley(1.0), {.most_iterations = 3});
  EXPECT_EQ(result.iterations, 3);
  EXPECT_FALSE(result.converged);
}

// A rotation that turns three directions onto three others, found on the sphere of unit quaternions; the
// closed form is nearest_rotation().
TEST(LevenbergMarquardt, MovesAlongRotationsAsWell) {
  const Quaternion truth = so3_exp({0.4, -1.1, 2.0});
  const std::array<Vector3, 3> from{Vector3(1, 0, 0), Vector3(0.2, 1, 0), Vector3(0.1, -0.3, 0.7)};
  const std::array<Vector3, 3> off{Vector3(0.01, 0, 0), Vector3(0, -0.02, 0), Vector3(0, 0, 0.03)};
  Matrix3 sum = Matrix3::Zero();
  for (std::size_t i = 0; i < 3; ++i) sum += (truth * from[i] + off[i]) * from[i].transpose();
  Quaternion q = Quaternion::Identity();
  const auto result = minimise<3>(
      q,
      [&](const Quaternion& at, NormalEquations<3>* equations) {
        double cost = 0.0;
        for (std::size_t i = 0; i < 3; ++i) {
          const Vector3 turned = at * from[i], r = turned - (truth * from[i] + off[i]);
          cost += r.squaredNorm();
          if (equations) equations->add(-hat(turned), r);
        }
        return cost;
      },
      [](const Quaternion& at, const Vector3& step) { return (so3_exp(step) * at).normalized(); });
  EXPECT_TRUE(result.converged);
  EXPECT_LT(angle_between(q, Quaternion(nearest_rotation(sum).rotation)), 1e-8);
}

// Equations of another kind: two unknowns, the second eliminated by hand from each step.
struct Eliminated {
  struct Step {
    double first, second;
  };
  Eigen::Matrix2d A;
  Eigen::Vector2d b;
  DampedStep<Step> solve(double damping) const {
    const double inner = A(1, 1) * (1 + damping), s = A(0, 0) * (1 + damping) - A(0, 1) * A(0, 1) / inner;
    const double first = -(b[0] - A(0, 1) * b[1] / inner) / s, second = -(b[1] + A(0, 1) * first) / inner;
    const double length2 = A(0, 0) * first * first + A(1, 1) * second * second;
    return {{first, second}, {damping * length2 - first * b[0] - second * b[1], std::sqrt(length2)}};
  }
};

TEST(LevenbergMarquardt, TakesEquationsThatEliminateSomeUnknowns) {
  const auto whole = from(Eigen::Vector2d(-1.2, 1.0), valley(1.0));
  Eigen::VectorXd x = Eigen::Vector2d(-1.2, 1.0);
  const auto result = minimise_with(
      Eliminated{}, x,
      [](const Eigen::VectorXd& at, Eliminated* equations) {
        Equations full(2);
        const double cost = valley(1.0)(at, &full);
        if (equations) equations->A = full.JtJ, equations->b = full.Jtr;
        return cost;
      },
      [](const Eigen::VectorXd& at, const Eliminated::Step& step) -> Eigen::VectorXd {
        return at + Eigen::Vector2d(step.first, step.second);
      });
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.iterations, whole.iterations);
  EXPECT_NEAR((x - whole.x).norm(), 0.0, 1e-9);
}

TEST(LevenbergMarquardt, WithNothingFreeItEndsAtOnce) {
  const auto result = from(Eigen::VectorXd(0), [](const Eigen::VectorXd&, Equations*) { return 3.0; });
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.cost, 3.0);
}

TEST(LevenbergMarquardt, ANumberThatIsNoneEndsItWithoutAnAnswer) {
  const auto result = from(Eigen::VectorXd::Constant(1, 2.0), [](const Eigen::VectorXd& x, Equations* at) {
    if (at) at->add(Eigen::MatrixXd::Constant(1, 1, std::nan("")), x);
    return x.squaredNorm();
  });
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(result.x[0], 2.0);
}

TEST(LevenbergMarquardt, VectorsOfFixedSizeNeedNoStepOfTheirOwn) {
  Eigen::Vector2d x(-1.2, 1.0);
  Eigen::VectorXd same = x;
  minimise(x, [](const Eigen::Vector2d& at, NormalEquations<2>* equations) {
    Equations full(2);
    const double cost = valley(1.0)(at, &full);
    if (equations) equations->JtJ = full.JtJ, equations->Jtr = full.Jtr;
    return cost;
  });
  minimise(same, valley(1.0));
  EXPECT_EQ(Eigen::VectorXd(x), same);
}

// One of nine values is wrong by far; against the minimum of the loss by a search on a fine grid.
TEST(LevenbergMarquardt, RobustLossesEndWhereTheGridSearchDoes) {
  const std::array<double, 9> seen{1.0, 1.1, 0.9, 1.05, 0.95, 1.02, 0.98, 1.2, 50.0};
  const auto with = [&](auto loss) {
    const auto evaluate = [&seen, loss](const Eigen::VectorXd& x, Equations* at) {
      double cost = 0.0;
      for (double y : seen) {
        const Eigen::VectorXd r = Eigen::VectorXd::Constant(1, x[0] - y);
        const Robust robust = loss(r.squaredNorm());
        cost += robust.loss;
        if (at) at->add(Eigen::MatrixXd::Identity(1, 1), r, robust.weight);
      }
      return cost;
    };
    double best = 0.0;
    for (double x = 0.5; x < 8.0; x += 1e-4)
      if (evaluate(Eigen::VectorXd::Constant(1, x), nullptr) <
          evaluate(Eigen::VectorXd::Constant(1, best), nullptr))
        best = x;
    const auto result = from(Eigen::VectorXd::Constant(1, 5.0), evaluate);
    EXPECT_TRUE(result.converged);
    EXPECT_NEAR(result.x[0], best, 1.1e-4);
    return result.x[0];
  };
  EXPECT_NEAR(with([](double s) { return Robust{s, 1.0}; }), 58.2 / 9.0, 1e-9);  // the mean, for comparison
  EXPECT_LT(with([](double s) { return huber(s, 0.2); }), 1.1);
  EXPECT_LT(with([](double s) { return cauchy(s, 0.04); }), 1.1);
}

TEST(RobustLoss, TheWeightIsTheDerivativeByTheSquare) {
  for (double s : {0.01, 0.9, 1.7, 4.0, 90.0}) {
    const double h = 1e-6 * s;
    EXPECT_NEAR(huber(s, 1.345).weight, (huber(s + h, 1.345).loss - huber(s - h, 1.345).loss) / (2 * h),
                1e-6);
    EXPECT_NEAR(cauchy(s, 2.0).weight, (cauchy(s + h, 2.0).loss - cauchy(s - h, 2.0).loss) / (2 * h), 1e-6);
  }
}

TEST(PosePrior, CostAndEquationsAgreeWithDifferences) {
  Matrix6 covariance = Matrix6::Identity();
  covariance.diagonal() << 1, 2, 3, 4, 5, 6;
  covariance(0, 4) = covariance(4, 0) = 0.5;
  const Pose<World, Tip> mean{so3_exp({0.3, 0.2, -0.5}), {1, 2, 3}},
      at = moved(mean, (Vector6() << 0.4, -0.3, 0.2, 0.1, 0.7, -0.2).finished());
  const PosePrior<World, Tip> prior(mean, covariance);
  Matrix6 A = Matrix6::Zero();
  Vector6 b = Vector6::Zero();
  EXPECT_DOUBLE_EQ(prior.add(at, A, b), prior.cost(at));
  const Vector6 e = deviation(at, mean);
  Matrix6 J = Matrix6::Identity();
  J.topLeftCorner<3, 3>() = so3_left_jacobian_inverse(e.head<3>());
  EXPECT_LT((A - J.transpose() * covariance.inverse() * J).norm(), 1e-12 * A.norm());
  for (Eigen::Index k = 0; k < 6; ++k) {
    constexpr double kStep = 1e-6;
    const double ahead = prior.cost(moved(at, kStep * Vector6::Unit(k))),
                 behind = prior.cost(moved(at, -kStep * Vector6::Unit(k)));
    EXPECT_NEAR(b[k], (ahead - behind) / (4 * kStep), 1e-8);
  }
  EXPECT_NEAR(prior.cost(at), deviation(at, mean).dot(covariance.inverse() * deviation(at, mean)), 1e-9);
}

}  // namespace
}  // namespace palpate::inline math
