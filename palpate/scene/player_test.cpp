#include "palpate/scene/player.h"

#include <gtest/gtest.h>

namespace palpate::scene {
namespace {

TEST(Quintic, MeetsBothEndsWithPositionVelocityAndAcceleration) {
  const HandState a{{1, 2, 3}, {0.1, 0.2, -0.3}, {1, -2, 0.5}}, b{{1.1, 1.8, 3.2}, {0.5, -1, 0}, {0, 3, 1}};
  const Quintic path(a, b, 0.37);
  EXPECT_NEAR((path.at(0).position - a.position).norm(), 0, 1e-14);
  EXPECT_NEAR((path.at(0.37).position - b.position).norm(), 0, 1e-13);
  EXPECT_NEAR((path.at(0.37).velocity - b.velocity).norm(), 0, 1e-12);
  EXPECT_NEAR((path.at(0.37).acceleration - b.acceleration).norm(), 0, 1e-11);
  const double h = 1e-5, t = 0.2;
  EXPECT_NEAR(((path.at(t + h).position - path.at(t - h).position) / (2 * h) - path.at(t).velocity).norm(), 0,
              1e-7);
  EXPECT_NEAR(((path.at(t + h).acceleration - path.at(t - h).acceleration) / (2 * h) - path.jerk(t)).norm(),
              0, 1e-5);
}

TEST(Reach, EndsAtTheJointLimitsAndWhereTheElbowIsStretched) {
  Reach reach;
  const auto tip = [&](double t1, double t2, double t3) {
    return Vector3((reach.X_world_base * device::phantom_tip({t1, t2, t3}, reach.lengths)).m);
  };
  EXPECT_TRUE(reach.contains(tip(0.0, 0.5, 0.3)));
  EXPECT_TRUE(reach.contains(tip(0.70, 0.5, 0.3)));
  EXPECT_FALSE(reach.contains(tip(0.76, 0.5, 0.3))) << "closer to the stop than the margin";
  EXPECT_FALSE(reach.contains(tip(0.0, -0.15, 0.3)));
  EXPECT_FALSE(reach.contains(tip(0.0, 0.5, 1.11)));
  EXPECT_FALSE(reach.contains(tip(0.0, 1.2, -0.25))) << "each joint within its range, the elbow stretched";
  EXPECT_FALSE(reach.contains(Vector3(0.0, 0.0, 5.0)));
  // A path whose ends are within, but not its middle.
  const HandState left{tip(-0.6, 0.0, 0.6), {0.0, -2.0, 0.0}, Vector3::Zero()};
  const HandState right{tip(0.6, 0.0, 0.6), {0.0, 2.0, 0.0}, Vector3::Zero()};
  EXPECT_TRUE(reach.contains(left.position) && reach.contains(right.position));
  EXPECT_FALSE(reach.contains(Quintic(left, right, 0.5)));
}

// A hand that obeys its law exactly goes along the plan itself, though its target is led ahead.
TEST(HandTrajectory, TakesAHandThatLagsAlongThePlan) {
  const HandLaw law{.stiffness = 250.0 / 0.225, .damping = 4.0 / 0.225};
  const HandState a{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, b{{0.2, 0.1, -0.1}, {0, 0, 0}, {0, 0, 0}};
  const Quintic path(a, b, 0.6);
  HandTrajectory guided(law, 30.0, a.position);
  Vector3 hand = a.position, velocity = Vector3::Zero();
  double most = 0.0, unled = 0.0;
  Vector3 follower = hand, follower_velocity = velocity;
  constexpr double kStep = 1e-3;
  for (int i = 1; i <= 600; ++i) {
    const double t = i * kStep;
    const auto& target = guided.follow(
        t, [&](double s) { return path.at(s); }, [&](double s) { return path.jerk(s); });
    velocity +=
        kStep * (law.stiffness * (target.position - hand) + law.damping * (target.velocity - velocity));
    hand += kStep * velocity;
    most = std::max(most, (hand - path.at(t).position).norm());
    follower_velocity += kStep * (law.stiffness * (path.at(t).position - follower) +
                                  law.damping * (path.at(t).velocity - follower_velocity));
    follower += kStep * follower_velocity;
    unled = std::max(unled, (follower - path.at(t).position).norm());
  }
  EXPECT_LT(most, 0.002);
  EXPECT_GT(unled, 2.0 * most) << "what the lead is for";
}

}  // namespace
}  // namespace palpate::scene
