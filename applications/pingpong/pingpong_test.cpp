#include "applications/pingpong/pingpong.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "applications/pingpong/looks.h"
#include "applications/pingpong/scene_for_tests.h"
#include "applications/pingpong/scene_view.h"
#include "palpate/physics/flight.h"
#include "tests/allocation_count.h"

namespace palpate::applications::pingpong {
namespace {

struct Session {
  explicit Session(const Settings& settings = {}, const scene::SceneDescription& scene = scene_for_tests())
      : game(scene, settings) {
    tip.X_world_tip.translation = {0.1, 3.0, 1.8};  // out of the way
  }
  void run(double s) {
    const auto end = now + seconds(s);
    while (now < end) step();
  }
  void step() {
    now += Duration(1'000'000);
    tip.time = now;
    game.step(now, Duration(1'000'000), tip, state);
    state.time = now;
  }
  PingPong game;
  scene::TipState tip;
  scene::SceneState state;
  Instant<PhysicsClock> now = Instant<PhysicsClock>::from_seconds(100.0);
};

TEST(PingPong, ServesNobodyReturnsAreMissesAndKeepComing) {
  Session session;
  session.run(30.0);
  const auto& c = session.state.counters;
  EXPECT_GE(c[kServes], 20);
  EXPECT_LE(c[kServes], 40);
  EXPECT_EQ(c[kReturned], 0);
  EXPECT_EQ(c[kHits], 0);
  EXPECT_GE(c[kMisses], c[kServes] - 1);
  EXPECT_EQ(session.game.impact().number, 0u);
}

TEST(PingPong, EveryServeHasTheAskedSpeedBouncesOnceAndReachesThePlayer) {
  for (const auto flight : {Flight::paper, Flight::full}) {
    const auto scene = with(scene_for_tests(), flight);
    const BallWorld world(scene);
    Random random(3, "test");
    const auto serves = make_serves(scene, game_settings(scene), world, {}, 50, random);
    ASSERT_EQ(serves.size(), 50u);
    for (const auto& serve : serves) {
      EXPECT_GE(serve.velocity.norm(), game_settings(scene).serve_speed[0] - 1e-12);
      EXPECT_LE(serve.velocity.norm(), game_settings(scene).serve_speed[1] + 1e-12);
      // Through the game's own dynamics, not the planes the serve was found with.
      BallWorld trial = world;
      trial.place(serve);
      BatMotion nowhere;
      nowhere.before.translation = nowhere.after.translation = {9, 9, 9};
      int bounces = 0;
      while (trial.ball().position.z() < 1.77) {
        for (const auto& touch : trial.step(0.001, nowhere)) bounces += touch.what == Touched::table;
      }
      EXPECT_EQ(bounces, 1);
      EXPECT_GT(trial.ball().position.y(), -1.52 + 0.15);
      EXPECT_LT(trial.ball().position.y(), -1.52 + 0.45);
    }
  }
}

// Until the bat has met a serve.
void meet_a_serve(Session& session) {
  // A wall of a bat: stands in the serve's way with its front towards the back wall and moves towards it.
  int tried = 0;
  while (session.state.counters[kHits] == 0 && tried++ < 20000) {
    session.step();
    const auto& ball = session.state.bodies[kBall];
    const bool close = session.state.counters[kPhase] == static_cast<int>(Phase::incoming) &&
                       ball.p().z() > 1.6 && session.state.counters[kTableBounces] > 0;
    if (!close) continue;
    // Held a little upwards in front of the ball, pushed against it at 2 m/s.
    const Vector3 n = Vector3(0, 0.12, -1.0).normalized();
    const Quaternion R = rotation_between(Vector3::UnitY(), n);
    session.tip.X_world_tip.rotation = R;
    session.tip.X_world_tip.translation = ball.p() - 0.033 * n - R * Vector3(0, 0, -0.09);
    session.tip.velocity = 2.0 * n;
    for (int i = 0; i < 40 && session.state.counters[kHits] == 0; ++i) {
      session.tip.X_world_tip.translation += 0.001 * session.tip.velocity;
      session.step();
    }
    break;
  }
}

TEST(PingPong, ABallBroughtToTheWallCountsAsReturnedAndTheHandGetsOneImpact) {
  Session session;
  meet_a_serve(session);
  ASSERT_EQ(session.state.counters[kHits], 1);
  const auto event = session.game.impact();
  EXPECT_EQ(event.number, 1u);
  EXPECT_NEAR(event.direction.norm(), 1.0, 1e-12);
  EXPECT_GT(event.direction.z(), 0.5) << "the hand is pushed back towards the player";
  EXPECT_GT(event.approach_speed, 1.0);
  EXPECT_LT(event.approach_speed, 6.0);
  EXPECT_EQ(event.duration, seconds(0.004));
  EXPECT_LE(event.start, session.now);
  EXPECT_GT(event.start, session.now - Duration(1'000'001));
  EXPECT_GT(session.state.impact.share, 0.0);
  EXPECT_GT(Vector3(session.state.impact.force.data()).dot(event.direction), 0.0);
  session.run(0.01);  // the contact lasts 4 ms, and the ball rides on the bat meanwhile
  session.tip.X_world_tip.translation = {0.1, 3.0, 1.8};
  session.tip.velocity.setZero();
  session.run(0.9);
  EXPECT_EQ(session.state.counters[kReturned], 1);
  EXPECT_EQ(session.state.counters[kLongest], 1);
  EXPECT_EQ(session.game.impact().number, 1u);
}

TEST(PingPong, TheImpactAtTheHandIsOfTheScenesContactAndOfBallAndBatTogether) {
  for (const auto contact :
       {scene::ContactModel::non_sticky, scene::ContactModel::paper, scene::ContactModel::hunt_crossley}) {
    const auto scene = with(with(scene_for_tests(), Flight::full, contact), "scene.bat_mass_kg", 0.17);
    Session session({}, scene);
    meet_a_serve(session);
    const auto event = session.game.impact();
    ASSERT_EQ(event.number, 1u);
    EXPECT_EQ(event.model, contact);
    EXPECT_NEAR(event.mass, 0.0027 * 0.17 / (0.0027 + 0.17), 1e-15);
    session.run(0.01);
    EXPECT_EQ(session.game.impact().number, 1u);
  }
}

TEST(PingPong, ImpactsAreMarkedAsJumps) {
  Session session;
  std::uint32_t jumps = 0;
  Vector3 v = Vector3::Zero(), p = Vector3::Zero();
  bool visible = false;
  for (int i = 0; i < 5000; ++i) {
    session.step();
    const auto& ball = session.state.bodies[kBall];
    if (i > 0 && visible && ball.jumps == jumps) {
      EXPECT_LT((ball.v() - v).norm(), 0.05)
          << "velocity may only change by gravity and air within a millisecond";
      EXPECT_LT((ball.p() - p).norm(), 0.01);
    }
    jumps = ball.jumps;
    v = ball.v();
    p = ball.p();
    visible = ball.visible != 0;
  }
}

TEST(PingPong, ControlsServePauseAndReset) {
  Session session;
  session.run(0.1);
  session.game.control(scene::Control::begin);
  session.run(0.25);
  EXPECT_EQ(session.state.counters[kServes], 1);
  session.game.control(scene::Control::pause);
  session.run(0.01);
  const Vector3 p = session.state.bodies[kBall].p();
  session.run(1.0);
  EXPECT_EQ(session.state.bodies[kBall].p(), p);
  EXPECT_EQ(session.state.bodies[kBall].v(), Vector3::Zero());
  session.game.control(scene::Control::resume);
  session.run(0.02);
  EXPECT_NE(session.state.bodies[kBall].p(), p);
  session.game.control(scene::Control::reset);
  session.run(0.1);
  EXPECT_EQ(session.state.counters[kServes], 0);
}

TEST(PingPong, StepDoesNotAllocate) {
  Session session;
  session.step();
  const std::size_t before = allocations();
  for (int i = 0; i < 8000; ++i) {
    // A bat that waves through the ball's way now and then.
    session.tip.X_world_tip.translation = {0.05, -1.25 + 0.1 * std::sin(0.011 * i), 1.75};
    session.step();
  }
  EXPECT_EQ(allocations() - before, 0u);
}

TEST(PingPong, ATipThatIsNotANumberIsNoBat) {
  Session session;
  session.tip.X_world_tip.translation.setConstant(std::nan(""));
  session.run(3.0);
  EXPECT_EQ(session.state.bodies[kBat].visible, 0u);
  EXPECT_TRUE(session.state.bodies[kBall].p().allFinite());
  EXPECT_GE(session.state.counters[kServes], 1);
}

TEST(PingPong, FastServesComeToo) {
  const auto scene = with(scene_for_tests(), "ball.serve_speed_m_s", std::vector<double>{3.0, 3.5});
  EXPECT_NO_THROW(PingPong{scene});
}

TEST(PingPong, AServeSpeedThatCannotReachThePlayerIsRefused) {
  const auto scene = with(scene_for_tests(), "ball.serve_speed_m_s", std::vector<double>{0.1, 0.2});
  EXPECT_THROW(PingPong{scene}, std::runtime_error);
}

TEST(PingPong, AMatchIsOverAfterItsServesAndTheNextBeginsOnWishOrByItself) {
  Settings settings;
  settings.over_s = 4.0;
  Session session(settings, with(scene_for_tests(), "match.serves", 2.0));
  const auto& c = session.state.counters;
  const auto run_until_over = [&] {
    for (int i = 0; i < 20000 && c[kLevel] >= 0; ++i) session.step();
    return c[kLevel] < 0;
  };
  ASSERT_TRUE(run_until_over());
  EXPECT_EQ(c[kLevel], -1) << "nothing was returned: the same level";
  EXPECT_EQ(c[kMatchServes], 2);
  session.run(3.9);
  EXPECT_EQ(c[kServes], 2);
  EXPECT_EQ(session.state.bodies[kBall].visible, 0u);
  session.run(0.5);
  EXPECT_EQ(c[kLevel], 1);
  EXPECT_EQ(c[kMatchServes], 1);
  ASSERT_TRUE(run_until_over());
  session.game.control(scene::Control::begin);
  session.run(0.3);
  EXPECT_EQ(c[kServes], 5);
  EXPECT_EQ(c[kMatchServes], 1);
  session.game.control(scene::Control::reset);
  session.step();
  EXPECT_EQ(c[kMatchServes], 0);
}

TEST(PingPong, AReturnInAMatchIsWorthItsLevel) {
  const auto scene = with(with(scene_for_tests(), "match.serves", 3.0), "match.level", 2.0);
  Session session({}, scene);
  meet_a_serve(session);
  session.run(0.01);  // the contact lasts 4 ms, and the ball rides on the bat meanwhile
  session.tip.X_world_tip.translation = {0.1, 3.0, 1.8};
  session.tip.velocity.setZero();
  session.run(0.9);
  const auto& c = session.state.counters;
  ASSERT_EQ(c[kReturned], 1);
  EXPECT_EQ(c[kMatchReturned], 1);
  EXPECT_EQ(c[kPoints], 2);
  const PingPongView scene_view(scene);
  EXPECT_EQ(scene_view.captions(session.state),
            (std::vector<std::string>{"2 points", fmt::format("serve {} of 3, 1 returned", c[kMatchServes]),
                                      "level 2"}));
}

TEST(PingPongView, TellsAMatchsEnd) {
  const PingPongView scene_view(with(scene_for_tests(), "match.serves", 20.0));
  scene::SceneState state;
  state.counters[kLevel] = -3;
  state.counters[kPoints] = 34;
  state.counters[kMatchServes] = 20;
  state.counters[kMatchReturned] = 15;
  state.counters[kBest] = 36;
  EXPECT_EQ(scene_view.captions(state),
            (std::vector<std::string>{"match over: 34 points", "15 of 20 returned, best match 36 points",
                                      "level 3 next"}));
  state.counters[kLevel] = 1;
  state.counters[kPoints] = state.counters[kBest] = 1;
  EXPECT_EQ(scene_view.captions(state).front(), "1 point");
  EXPECT_EQ(scene_view.captions(state).back(), "level 1, best match 1 point");
}

TEST(PingPongView, DrawsWhatIsVisibleWhereItIs) {
  const PingPongView scene_view(scene_for_tests());
  scene::SceneState state;
  state.body_count = 2;
  state.bodies[kBall].set_p({1, 2, 3});
  const auto items = scene_view.draw(state);
  ASSERT_EQ(items.size(), 4u);  // ball, two sides of the bat, handle
  EXPECT_EQ(items[0].look, kBallLook);
  EXPECT_EQ(items[0].position, Vector3(1, 2, 3));
  state.bodies[kBall].visible = 0;
  EXPECT_EQ(scene_view.draw(state).size(), 3u);
  state.counters[kServes] = 2;
  state.counters[kReturned] = 1;
  state.counters[kRally] = 3;
  state.counters[kLongest] = 4;
  const std::vector<std::string> score{"serves returned 1 of 2", "returns in a row 3", "most in a row 4"};
  EXPECT_EQ(scene_view.captions(state), score);
}

// Of the blade's middle, as seen along the bat's normal.
double covered_share(const std::vector<scene::DrawItem>& items, double radius) {
  int covered = 0, looked = 0;
  for (double x = -radius; x <= radius; x += 0.0021)
    for (double z = -radius; z <= radius; z += 0.0023) {
      if (x * x + z * z > radius * radius) continue;
      ++looked;
      const auto covers = [&](const scene::TriangleMesh& mesh, const std::array<std::uint32_t, 3>& t) {
        int left = 0;
        for (int i = 0; i < 3; ++i) {
          const Vector3 &a = mesh.vertices[t[static_cast<std::size_t>(i)]],
                        &b = mesh.vertices[t[static_cast<std::size_t>((i + 1) % 3)]];
          left += (b.x() - a.x()) * (z - a.z()) - (b.z() - a.z()) * (x - a.x()) > 0.0 ? 1 : -1;
        }
        return std::abs(left) == 3;
      };
      covered += std::any_of(items.begin(), items.end(), [&](const scene::DrawItem& item) {
        return std::any_of(item.mesh->triangles.begin(), item.mesh->triangles.end(),
                           [&](const auto& t) { return covers(*item.mesh, t); });
      });
    }
  return static_cast<double>(covered) / looked;
}

TEST(PingPongView, TheBallIsSeenThroughABatWithStrings) {
  PingPongView scene_view(scene_for_tests());
  scene::SceneState state;
  state.body_count = 2;
  state.bodies[kBall].visible = 0;
  EXPECT_GT(covered_share(scene_view.draw(state), 0.055), 0.99);
  scene_view.set_look(scene_view.look_at_window());
  const auto strung = scene_view.draw(state);
  EXPECT_LT(covered_share(strung, 0.055), 0.25);
  EXPECT_GT(covered_share(strung, 0.055), 0.05);
  // As large as the blade.
  double widest = 0.0;
  for (const auto& item : strung)
    if (item.look != kHandleLook)
      for (const auto& v : item.mesh->vertices) widest = std::max(widest, std::hypot(v.x(), v.z()));
  EXPECT_NEAR(widest, GameSettings{}.bat_radius, 1e-3);
  scene_view.set_look(0);
  EXPECT_GT(covered_share(scene_view.draw(state), 0.055), 0.99);
}

TEST(PingPongView, TheHandleEndsAtTheTip) {
  const auto scene = scene_for_tests();
  const PingPongView scene_view(scene);
  scene::SceneState state;
  state.body_count = 2;
  double nearest = 1.0;
  for (const auto& item : scene_view.draw(state)) {
    if (item.look != kHandleLook) continue;
    for (const auto& v : item.mesh->vertices) nearest = std::min(nearest, (v + scene.carried_offset).norm());
  }
  EXPECT_LT(nearest, 1e-9);  // the middle of the cylinder's end
}

// --- what a picture of the near future shows

scene::SceneState ball_and_bat(const Vector3& ball, const Vector3& velocity) {
  scene::SceneState state;
  state.body_count = 2;
  state.bodies[kBall].set_p(ball);
  state.bodies[kBall].set_v(velocity);
  state.bodies[kBat].set_p({0.0, -1.2, 1.9});
  return state;
}

TEST(PingPongPrediction, AFreeBallFallsAndTheBatMovesOn) {
  const PingPongView scene_view(with(scene_for_tests(), Flight::paper));
  auto state = ball_and_bat({0.0, -1.1, 1.3}, {0.2, 1.0, 1.5});
  state.bodies[kBat].set_v({0.5, 0.0, -0.3});
  state.bodies[kBat].set_w({0.0, 2.0, 0.0});
  const auto next = scene_view.predict(state, std::chrono::milliseconds(60));
  const double t = 0.06;
  const Vector3 fallen =
      Vector3(0.0, -1.1, 1.3) + t * Vector3(0.2, 1.0, 1.5) - 0.5 * 9.81 * t * t * Vector3::UnitY();
  EXPECT_LT((next.bodies[kBall].p() - fallen).norm(), 1e-9);
  EXPECT_LT((next.bodies[kBat].p() - Vector3(0.03, -1.2, 1.882)).norm(), 1e-12);
  EXPECT_LT(angle_between(next.bodies[kBat].q(), so3_exp({0.0, 0.12, 0.0})), 1e-12);
  EXPECT_EQ(next.time, state.time + std::chrono::milliseconds(60));
}

TEST(PingPongPrediction, ABallStaysWhereItMeetsTheTable) {
  const auto scene = with(scene_for_tests(), Flight::paper);
  const PingPongView scene_view(scene);
  const double above = 0.05;  // of the ball's lowest point
  const auto state =
      ball_and_bat({0.0, -1.52 + game_settings(scene).ball_radius + above, 1.3}, {0.8, -2.0, -1.0});
  // -2 t - g t^2 / 2 = -0.05
  const double met = (-2.0 + std::sqrt(4.0 + 2.0 * 9.81 * above)) / 9.81;
  for (const int ms : {40, 100}) {
    const auto next = scene_view.predict(state, std::chrono::milliseconds(ms)).bodies[kBall].p();
    EXPECT_LT((next - Vector3(0.8 * met, -1.52 + game_settings(scene).ball_radius, 1.3 - met)).norm(),
              5e-6)  // the chord of a 2 ms step
        << ms;
  }
  const auto before = scene_view.predict(state, std::chrono::milliseconds(20)).bodies[kBall].p();
  EXPECT_GT(before.y(), -1.52 + game_settings(scene).ball_radius + 0.005);
}

TEST(PingPongPrediction, ABallThatMeetsTheBatGoesWithItAndNeverThroughIt) {
  const auto scene = with(scene_for_tests(), Flight::paper);
  const PingPongView scene_view(scene);
  auto state = ball_and_bat({0.01, -1.2 + 0.06, 1.9}, {0.0, -3.0, 0.0});
  state.bodies[kBat].set_v({0.0, 1.0, 0.2});
  double least = 1.0;
  Vector3 there = Vector3::Zero();
  for (int ms = 0; ms <= 80; ++ms) {
    const auto next = scene_view.predict(state, std::chrono::milliseconds(ms));
    const Vector3 off = next.bodies[kBall].p() - next.bodies[kBat].p();
    least = std::min(least, off.y());
    if (ms == 40) there = off;
    if (ms > 40) {
      EXPECT_LT((off - there).norm(), 1e-9);
    }
  }
  // Its surface on the rubber; in the 3 ms before it met the bat it fell freely.
  EXPECT_NEAR(least, game_settings(scene).ball_radius + 0.5 * BallWorld::kBatThickness, 1e-5);
  // In the middle of an impact it goes with the bat at once.
  state.impact.share = 0.5;
  const Vector3 before = state.bodies[kBall].p() - state.bodies[kBat].p();
  const auto next = scene_view.predict(state, std::chrono::milliseconds(30));
  EXPECT_LT((next.bodies[kBall].p() - next.bodies[kBat].p() - before).norm(), 1e-12);
}

}  // namespace
}  // namespace palpate::applications::pingpong
