#include "applications/pingpong/stroke_assist.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "applications/pingpong/pingpong.h"
#include "applications/pingpong/scene_for_tests.h"
#include "applications/pingpong/serve.h"

namespace palpate::applications::pingpong {
namespace {

// A ball off the wall on its way to the player, a person whose pointer is a ray from their eye, and the hand
// where the mouse has it.
struct MouseSetup {
  scene::SceneDescription scene = scene_for_tests();
  scene::Reach reach;
  scene::PlayerSettings settings;
  physics::BallState served;
  Vector3 eye{0.0, -0.95, 2.3};
  device::HandTarget hand;

  MouseSetup() {
    reach.X_world_base = {rotation_from_xyz({0.0262, -0.0698, 0.0140}), Vector3(0.10, -1.40, 1.75)};
    Random random(1, "serve");
    served = make_serves(scene, game_settings(scene), BallWorld(scene), {}, 1, random).front();
    settings.reaction_s = settings.aim_sd = settings.perception_sd = 0.0;
    const Strokes strokes(scene, reach, settings);
    hand.tip.m = strokes.home();
    hand.R_world_tip = strokes.home_rotation();
  }
  // Where the ball is at t, by the same physics in small steps.
  physics::BallState ball(const Strokes& strokes, double t) const {
    physics::BallState at = served;
    physics::advance(strokes.model(), strokes.planes(), at, t, 0.001);
    return at;
  }
  scene::SceneState shown(const Strokes& strokes, double t) const {
    scene::SceneState state;
    const physics::BallState at = ball(strokes, t);
    state.time = Instant<PhysicsClock>::from_seconds(t);
    state.body_count = 2;
    state.bodies[kBall].set_p(at.position);
    state.bodies[kBall].set_v(at.velocity);
    state.counters[kPhase] = static_cast<std::int32_t>(Phase::incoming);
    physics::BallState flown = served;
    state.counters[kTableBounces] = physics::advance(strokes.model(), strokes.planes(), flown, t, 0.001);
    state.counters[kServes] = 1;
    return state;
  }
  scene::Led pointing_at(const Vector3& place, double side = 0.0) const {
    return {hand, eye, (place - eye).normalized(), side};
  }
};

struct Course {
  double begins = 0.0, ends = 0.0;  // s; 0: never
  double nearest = 1e9;             // of the bat's middle from the ball, m
  Vector3 bat_velocity = Vector3::Zero(), normal = Vector3::UnitZ();
  double meets = 0.0;
  double hardest = 0.0;  // m/s^2, of the target
};

// One flight with pictures at 30 Hz that are 60 ms old when they are shown.
template <typename Point>
Course watch(const MouseSetup& setup, const Point& pointer) {
  const Strokes strokes(setup.scene, setup.reach, setup.settings);
  StrokeAssist assist(setup.scene, setup.reach, setup.settings);
  Course course;
  double next = 0.06;
  std::optional<device::HandTarget> before;
  Vector3 velocity_before = Vector3::Zero();
  for (int ms = 1; ms < 900; ++ms) {
    const double t = 1e-3 * ms;
    if (t >= next) {
      assist.show(setup.shown(strokes, next - 0.06));
      next += 1.0 / 30.0;
    }
    const auto target = assist.act(Instant<PhysicsClock>::from_seconds(t), pointer(strokes, t));
    if (target) {
      if (course.begins == 0.0) course.begins = t;
      course.ends = t;
      const Vector3 bat = target->tip.m + target->R_world_tip * setup.scene.carried_offset;
      const double off = (bat - setup.ball(strokes, t).position).norm();
      if (off < course.nearest) {
        course.nearest = off, course.meets = t;
        course.bat_velocity = target->velocity;
        course.normal = target->R_world_tip * Vector3::UnitY();
      }
      if (!before) velocity_before.setZero();
      if (before) {
        const Vector3 velocity = (target->tip.m - before->tip.m) / 1e-3;
        if (velocity_before != Vector3::Zero())
          course.hardest = std::max(course.hardest, (velocity - velocity_before).norm() / 1e-3);
        velocity_before = velocity;
      }
    }
    before = target;
  }
  return course;
}

TEST(StrokeAssist, ABallThatThePointerMeetsIsMetWithAStrokeTowardsTheWall) {
  const MouseSetup setup;
  const auto course = watch(setup, [&](const Strokes& strokes, double t) {
    return setup.pointing_at(setup.ball(strokes, t + 0.1).position);
  });
  ASSERT_GT(course.begins, 0.0);
  // The bat's middle stands behind the ball's by its radius and half the blade; the target leads the hand,
  // which follows later, by some centimetres.
  EXPECT_LT(course.nearest, 0.06);
  EXPECT_LT(course.bat_velocity.z(), -0.2);
  EXPECT_LT(course.normal.z(), -0.7);
  EXPECT_LT(course.ends - course.begins, 0.45);
  EXPECT_LT(course.hardest, setup.settings.max_acceleration + 0.5);  // rounding of second differences
}

TEST(StrokeAssist, ABallThatThePointerDoesNotMeetIsLeftAlone) {
  const MouseSetup setup;
  for (const Vector3& aside : {Vector3(0.5, 0.0, 0.0), Vector3(-0.5, 0.0, 0.0), Vector3(0.0, 0.5, 0.0)}) {
    const auto course = watch(setup, [&](const Strokes& strokes, double t) {
      return setup.pointing_at(setup.ball(strokes, t + 0.1).position + aside);
    });
    EXPECT_EQ(course.begins, 0.0) << aside.transpose();
  }
}

TEST(StrokeAssist, APointerThatGoesAwayCallsTheStrokeOff) {
  const MouseSetup setup;
  const auto follow = [&](const Strokes& strokes, double t) {
    return setup.pointing_at(setup.ball(strokes, t + 0.1).position);
  };
  const auto whole = watch(setup, follow);
  ASSERT_GT(whole.begins, 0.0);
  const double away = whole.begins + 0.05;
  const auto course = watch(setup, [&](const Strokes& strokes, double t) {
    return t < away ? follow(strokes, t) : setup.pointing_at({1.0, -1.0, 1.5});
  });
  EXPECT_NEAR(course.begins, whole.begins, 1e-9);
  EXPECT_LT(course.ends, away + 0.02);
}

TEST(StrokeAssist, AButtonSendsTheBallToItsSide) {
  const MouseSetup setup;
  const Strokes strokes(setup.scene, setup.reach, setup.settings);
  const physics::BallState in{{0.05, -1.25, 1.65}, {0.05, -0.4, 1.4}, Vector3::Zero()};
  const auto at_wall = [&](double side) {
    const Stroke stroke = strokes.aim(in, 2.6, 0.3, side);
    physics::BallState ball = physics::bounce(strokes.model(), in, stroke.normal,
                                              BallWorld(setup.scene).bat_law(), stroke.speed * stroke.normal);
    for (int i = 0; i < 2000 && ball.position.z() > 0.82; ++i)
      ball = physics::fly(strokes.model(), ball, 0.001);
    return ball.position.x();
  };
  const double straight = at_wall(0.0);
  // The aim is tried in thought to a centimetre.
  EXPECT_NEAR(at_wall(StrokeAssist::kAside_m) - straight, StrokeAssist::kAside_m, 0.02);
  EXPECT_NEAR(at_wall(-StrokeAssist::kAside_m) - straight, -StrokeAssist::kAside_m, 0.02);
}

}  // namespace
}  // namespace palpate::applications::pingpong
