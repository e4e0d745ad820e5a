#include "palpate/scene/scene_state.h"

#include <gtest/gtest.h>

#include <cstring>

namespace palpate::scene {
namespace {

const Vector3 kDown(0.0, -9.81, 0.0);

// A body in free flight, as it is at time t, seconds.
SceneState flight(double t, const Vector3& p0, const Vector3& v0, const Vector3& w) {
  SceneState state;
  state.time = Instant<PhysicsClock>::from_seconds(t);
  state.body_count = 1;
  auto& body = state.bodies[0];
  body.set_p(p0 + t * v0 + 0.5 * t * t * kDown);
  body.set_v(v0 + t * kDown);
  body.set_w(w);
  body.set_q(so3_exp(t * w));
  return state;
}

TEST(SceneState, TheEndsAreTheStatesThemselves) {
  const auto a = flight(0.0, {1, 2, 3}, {4, 5, 6}, {7, 8, 9}),
             b = flight(0.001, {1, 2, 3}, {4, 5, 6}, {7, 8, 9});
  const auto at_a = interpolate(a, b, 0.0, kDown), at_b = interpolate(a, b, 1.0, kDown);
  EXPECT_EQ(at_a.bodies[0].position, a.bodies[0].position);
  EXPECT_EQ(at_b.bodies[0].position, b.bodies[0].position);
  EXPECT_EQ(at_b.time, b.time);
}

TEST(SceneState, FreeFlightIsInterpolatedExactly) {
  const Vector3 p(0.1, -1.2, 0.9), v(0.3, 1.5, 2.5), w(0.0, 40.0, -80.0);
  const auto a = flight(0.0, p, v, w), b = flight(0.010, p, v, w);
  for (double s : {0.1, 0.37, 0.5, 0.93}) {
    const auto truth = flight(0.010 * s, p, v, w);
    const auto state = interpolate(a, b, s, kDown);
    EXPECT_EQ(state.time, truth.time);
    EXPECT_NEAR((state.bodies[0].p() - truth.bodies[0].p()).norm(), 0.0, 1e-14);
    EXPECT_NEAR((state.bodies[0].v() - truth.bodies[0].v()).norm(), 0.0, 1e-14);
    EXPECT_NEAR(angle_between(state.bodies[0].q(), truth.bodies[0].q()), 0.0, 1e-9);
  }
}

TEST(SceneState, NoPathLeadsAcrossAnImpact) {
  // Falls at 3 m/s, bounces at 4 ms with e = 1: between the states at 0 and 10 ms the ball never goes
  // through.
  auto a = flight(0.0, {0, 0.012, 0}, {0, -3, 0}, Vector3::Zero());
  auto b = a;
  b.time = Instant<PhysicsClock>::from_seconds(0.010);
  b.bodies[0].set_p({0, 0.018, 0});
  b.bodies[0].set_v({0, 3, 0});
  b.bodies[0].jumps = a.bodies[0].jumps + 1;
  b.counters[0] = 1;
  const auto before = interpolate(a, b, 0.3, Vector3::Zero()),
             after = interpolate(a, b, 0.7, Vector3::Zero());
  EXPECT_NEAR(before.bodies[0].p().y(), 0.003, 1e-15);
  EXPECT_NEAR(before.bodies[0].v().y(), -3.0, 1e-15);
  EXPECT_EQ(before.bodies[0].jumps, a.bodies[0].jumps);
  EXPECT_NEAR(after.bodies[0].p().y(), 0.009, 1e-15);
  EXPECT_NEAR(after.bodies[0].v().y(), 3.0, 1e-15);
  EXPECT_EQ(after.bodies[0].jumps, b.bodies[0].jumps);
  EXPECT_EQ(after.counters[0], 0) << "what the later state counted had not happened yet";
}

TEST(SceneState, GravityBendsThePathBesideAnImpact) {
  auto a = flight(0.0, {0, 1, 0}, {1, 0, 0}, Vector3::Zero());
  auto b = flight(0.010, {5, 1, 0}, {1, 0, 0}, Vector3::Zero());
  b.bodies[0].jumps = 1;
  const auto state = interpolate(a, b, 0.4, kDown);
  const auto truth = flight(0.004, {0, 1, 0}, {1, 0, 0}, Vector3::Zero());
  EXPECT_NEAR((state.bodies[0].p() - truth.bodies[0].p()).norm(), 0.0, 1e-15);
}

TEST(SceneState, ExtrapolationKeepsVelocities) {
  const auto a = flight(0.0, {0, 1, 0}, {1, 2, 3}, {0, 0, 10});
  const auto state = extrapolate(a, seconds(0.01));
  EXPECT_EQ(state.time, a.time + seconds(0.01));
  EXPECT_NEAR((state.bodies[0].p() - Vector3(0.01, 1.02, 0.03)).norm(), 0.0, 1e-15);
  EXPECT_EQ(state.bodies[0].velocity, a.bodies[0].velocity);
  EXPECT_NEAR(angle_between(state.bodies[0].q(), so3_exp({0, 0, 0.1})), 0.0, 1e-9);
}

}  // namespace
}  // namespace palpate::scene
