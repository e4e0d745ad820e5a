#include "palpate/physics/balls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "palpate/math/random_vector.h"

namespace palpate::physics {
namespace {

TEST(Balls, TwoBallsTouchWhenFineStepsSayTheyDo) {
  Random random(1, "balls/touch");
  const BallModel model;
  int touched = 0;
  for (int i = 0; i < 300; ++i) {
    const BallState a{Vector3::Zero(), uniform3(random, 5.0), uniform3(random, 100.0)};
    const BallState b{uniform3(random, 0.08), uniform3(random, 5.0), uniform3(random, 100.0)};
    if (b.position.norm() <= 2.0 * model.radius) continue;
    constexpr double kFlown = 0.010, kFine = 1e-6;
    double expected = -1.0;
    for (double t = 0.0; t <= kFlown && expected < 0.0; t += kFine)
      if ((fly(model, b, t).position - fly(model, a, t).position).norm() <= 2.0 * model.radius) expected = t;
    const auto touch = first_touch(model, a, b, kFlown);
    ASSERT_EQ(touch.has_value(), expected >= 0.0) << i;
    if (!touch) continue;
    EXPECT_NEAR(*touch, expected, 1.1e-6);
    ++touched;
  }
  EXPECT_GT(touched, 10);
}

TEST(Balls, AnImpactKeepsMomentumAndAngularMomentumAndItsRestitution) {
  Random random(2, "balls/collide");
  const BallModel model;
  const double inertia = 2.0 / 3.0 * model.mass * model.radius * model.radius;
  for (int i = 0; i < 1000; ++i) {
    BallState a{uniform3(random, 1.0), uniform3(random, 10.0), uniform3(random, 200.0)}, b = a;
    b.position += 2.0 * model.radius * uniform3(random, 1.0).normalized();
    b.velocity = uniform3(random, 10.0);
    b.spin = uniform3(random, 200.0);
    const BallState a0 = a, b0 = b;
    const double e = random.uniform(0.1, 1.0), mu = random.uniform(0.0, 1.0);
    collide(model, {e, mu}, a, b);
    const Vector3 n = (b.position - a.position).normalized();
    const double approach = -n.dot(b0.velocity - a0.velocity);
    if (approach <= 0.0) {
      EXPECT_EQ(a.velocity, a0.velocity);
      continue;
    }
    EXPECT_NEAR(n.dot(b.velocity - a.velocity), e * approach, 1e-12);
    EXPECT_NEAR((a.velocity + b.velocity - a0.velocity - b0.velocity).norm(), 0.0, 1e-13);
    const auto angular = [&](const BallState& x, const BallState& y) {
      return Vector3(model.mass * (x.position.cross(x.velocity) + y.position.cross(y.velocity)) +
                     inertia * (x.spin + y.spin));
    };
    EXPECT_NEAR((angular(a, b) - angular(a0, b0)).norm(), 0.0, 1e-14);
    const auto energy = [&](const BallState& x) {
      return 0.5 * model.mass * x.velocity.squaredNorm() + 0.5 * inertia * x.spin.squaredNorm();
    };
    EXPECT_LE(energy(a) + energy(b), (energy(a0) + energy(b0)) * (1.0 + 1e-12));
  }
}

TEST(Balls, EqualBallsExchangeTheirVelocitiesHeadOn) {
  auto model = BallModel::paper();
  model.gravity.setZero();
  std::vector<BallState> balls{{{0, 0, 0}, {2, 0, 0}, {}}, {{0.1, 0, 0}, {-1, 0, 0}, {}}};
  for (auto& ball : balls) ball.spin.setZero();
  EXPECT_EQ(advance_all(model, {}, {1.0, 0.3}, balls, 0.1), 1);
  EXPECT_NEAR(balls[0].velocity.x(), -1.0, 1e-12);
  EXPECT_NEAR(balls[1].velocity.x(), 2.0, 1e-12);
}

TEST(Balls, OneBallAloneFliesAsItDoesByItself) {
  const BallModel model;
  BouncePlane floor;
  BallState alone{{0, 1, 0}, {1, 0, 2}, {10, 20, 30}};
  std::vector<BallState> balls{alone};
  int bounces = 0, impacts = 0;
  for (int i = 0; i < 100; ++i) {
    bounces += advance(model, {&floor, 1}, alone, 0.01);
    impacts += advance_all(model, {&floor, 1}, {}, balls, 0.01);
  }
  EXPECT_EQ(bounces, impacts);
  EXPECT_NEAR((alone.position - balls[0].position).norm(), 0.0, 1e-12);
}

TEST(Balls, ABoxfulNeverOverlapsNorLeaves) {
  Random random(3, "balls/box");
  const BallModel model;
  std::vector<BouncePlane> box;
  for (const Vector3& n : {Vector3(1, 0, 0), Vector3(-1, 0, 0), Vector3(0, 1, 0), Vector3(0, -1, 0),
                           Vector3(0, 0, 1), Vector3(0, 0, -1)}) {
    BouncePlane side;
    side.normal = n;
    side.point = -0.25 * n;
    side.law = {0.98, 0.1};
    box.push_back(side);
  }
  std::vector<BallState> balls;
  for (int i = 0; i < 12; ++i) {
    BallState ball{Vector3(0.1 * (i % 3) - 0.1, 0.1 * (i / 3) - 0.15, 0.0), uniform3(random, 5.0),
                   uniform3(random, 50.0)};
    balls.push_back(ball);
  }
  int impacts = 0;
  for (int i = 0; i < 2000; ++i) {  // two seconds; by then most energy is gone, and they lie on the ground
    impacts += advance_all(model, box, {0.95, 0.1}, balls, 0.001);
    for (std::size_t a = 0; a < balls.size(); ++a) {
      ASSERT_LT(balls[a].position.cwiseAbs().maxCoeff(), 0.25 + 1e-4) << "step " << i;
      for (std::size_t b = a + 1; b < balls.size(); ++b)
        ASSERT_GT((balls[a].position - balls[b].position).norm(), 2.0 * model.radius - 1e-4) << "step " << i;
    }
  }
  EXPECT_GT(impacts, 100);
}

}  // namespace
}  // namespace palpate::physics
