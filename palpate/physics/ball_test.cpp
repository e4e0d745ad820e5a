#include "palpate/physics/ball.h"

#include <gtest/gtest.h>

#include "palpate/math/random_vector.h"

namespace palpate::physics {
namespace {

TEST(Ball, ThePapersBallFallsExactlyInOneStep) {
  const auto model = BallModel::paper();
  const BallState start{{0, 1, 0}, {1, 2, 3}, Vector3::Zero()};
  BallState many = start;
  for (int i = 0; i < 1000; ++i) many = fly(model, many, 0.001);
  const auto one = fly(model, start, 1.0);
  EXPECT_NEAR((one.position - Vector3(1, 1 + 2 - 4.905, 3)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((many.position - one.position).norm(), 0.0, 1e-12);  // 1000 roundings
}

TEST(Ball, DragAloneFollowsItsClosedForm) {
  // v' = -k v^2: v = v0 / (1 + k v0 t), x = ln(1 + k v0 t) / k.
  BallModel model;
  model.gravity.setZero();
  model.drag = 0.13;
  BallState ball{Vector3::Zero(), {6.7, 0, 0}, Vector3::Zero()};
  for (int i = 0; i < 1000; ++i) ball = fly(model, ball, 0.001);
  EXPECT_NEAR(ball.position.x(), std::log1p(0.13 * 6.7) / 0.13, 1e-6);
  EXPECT_NEAR(ball.velocity.x(), 6.7 / (1.0 + 0.13 * 6.7), 1e-6);
}

TEST(Ball, TheMidpointRuleIsOfSecondOrder) {
  const BallModel model;
  const auto at_end = [&](int steps) {
    BallState ball{Vector3::Zero(), {5, 2, 1}, {10, -80, 30}};
    for (int i = 0; i < steps; ++i) ball = fly(model, ball, 1.0 / steps);
    return ball.position;
  };
  const Vector3 fine = at_end(100000);
  const double coarse = (at_end(100) - fine).norm(), halved = (at_end(200) - fine).norm();
  EXPECT_NEAR(coarse / halved, 4.0, 0.2);
  EXPECT_LT((at_end(1000) - fine).norm(), 2e-6);  // 1 ms: micrometres after a second
}

TEST(Ball, TerminalSpeedBalancesGravity) {
  BallModel model;
  BallState ball;
  for (int i = 0; i < 10000; ++i) ball = fly(model, ball, 0.001);
  EXPECT_NEAR(ball.velocity.y(), -std::sqrt(9.81 / model.drag), 1e-3);
}

TEST(Ball, TopspinPullsDown) {
  // Flying along -z, topspin turns the top forward: spin x velocity points down.
  const BallModel model;
  const Vector3 v(0, 0, -5);
  const Vector3 topspin = Vector3::UnitY().cross(v).normalized() * 100.0;
  EXPECT_LT(ball_acceleration(model, v, topspin).y(), -9.81 - 1.0);
}

TEST(Ball, RestitutionIsExactOnAMovingSurface) {
  Random random(1, "bounce");
  const BallModel model;
  for (int i = 0; i < 1000; ++i) {
    const Vector3 n = uniform3(random, 1.0).normalized();
    const BallState ball{Vector3::Zero(), uniform3(random, 10.0), uniform3(random, 100.0)};
    const Vector3 surface = uniform3(random, 3.0);
    const double e = random.uniform(0.1, 1.0), approach = -n.dot(ball.velocity - surface);
    const auto after = bounce(model, ball, n, {e, 0.25}, surface);
    if (approach <= 0.0) {
      EXPECT_EQ(after.velocity, ball.velocity);
    } else {
      EXPECT_NEAR(n.dot(after.velocity - surface), e * approach, 1e-13);
    }
  }
}

TEST(Ball, AGrippingThinShellKeepsThreeFifthsOfItsSlip) {
  const BallModel model;
  const BallState ball{Vector3::Zero(), {1.0, -3.0, 0.0}, Vector3::Zero()};
  const auto after = bounce(model, ball, Vector3::UnitY(), {0.93, 0.25});
  EXPECT_NEAR(after.velocity.x(), 0.6, 1e-15);
  // Rolling: the touching point stands still, v + w x (-R n) = 0.
  EXPECT_NEAR((after.velocity - model.radius * after.spin.cross(Vector3::UnitY())).x(), 0.0, 1e-14);
}

TEST(Ball, FrictionNeverGainsEnergyAndKeepsAngularMomentumAboutTheContact) {
  Random random(2, "bounce");
  const BallModel model;
  const double inertia = 2.0 / 3.0 * model.mass * model.radius * model.radius;
  const auto energy = [&](const BallState& b) {
    return 0.5 * model.mass * b.velocity.squaredNorm() + 0.5 * inertia * b.spin.squaredNorm();
  };
  for (int i = 0; i < 1000; ++i) {
    const Vector3 n = uniform3(random, 1.0).normalized();
    const BallState ball{Vector3::Zero(), uniform3(random, 10.0), uniform3(random, 300.0)};
    const auto after = bounce(model, ball, n, {1.0, random.uniform(0.0, 2.0)});
    EXPECT_LE(energy(after), energy(ball) * (1 + 1e-12));
    const auto about_contact = [&](const BallState& b) {
      return Vector3(model.radius * n.cross(model.mass * b.velocity) + inertia * b.spin);
    };
    EXPECT_NEAR((about_contact(after) - about_contact(ball)).norm(), 0.0, 1e-15);
  }
}

TEST(Ball, SlidingFrictionIsBoundedByCoulomb) {
  const BallModel model;
  const BallState ball{Vector3::Zero(), {10.0, -1.0, 0.0}, Vector3::Zero()};
  const auto after = bounce(model, ball, Vector3::UnitY(), {0.9, 0.25});
  EXPECT_NEAR(10.0 - after.velocity.x(), 0.25 * 1.9 * 1.0, 1e-14);
}

}  // namespace
}  // namespace palpate::physics
