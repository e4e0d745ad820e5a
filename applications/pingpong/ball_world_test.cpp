#include "applications/pingpong/ball_world.h"

#include <gtest/gtest.h>

#include <cmath>

#include "applications/pingpong/scene_for_tests.h"
#include "palpate/core/random.h"

namespace palpate::applications::pingpong {
namespace {

Vector3 random_vector(Random& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

BatMotion far_away() {
  BatMotion bat;
  bat.before.translation = bat.after.translation = {10, 10, 10};
  return bat;
}

// A bat that moves with constant velocity, face +y along `normal`; where it is at time t.
struct SteadyBat {
  Quaternion rotation;
  Vector3 start, velocity;
  BatMotion over(double t, double dt) const {
    return {
        {rotation, start + t * velocity}, {rotation, start + (t + dt) * velocity}, velocity, Vector3::Zero()};
  }
  Vector3 normal() const { return rotation * Vector3::UnitY(); }
};

TEST(BallWorld, TheTableGivesBackItsRestitutionExactly) {
  for (const double speed : {3.0, 10.0, 20.0, 30.0}) {
    for (int phase = 0; phase < 20; ++phase) {
      auto scene = scene_for_tests();
      scene.gravity.setZero();
      BallWorld world(with(scene, Flight::paper));
      world.place({{0, -1.4 + 0.0007 * phase, 1.3}, {0, -speed, 0}, Vector3::Zero()});
      double approach = 0.0;
      for (int i = 0; i < 200 && approach == 0.0; ++i) {
        for (const auto& touch : world.step(0.001, far_away())) approach = touch.approach_speed;
      }
      ASSERT_GT(approach, 0.0);
      EXPECT_NEAR(world.ball().velocity.y() / approach, 0.93, 1e-12);
    }
  }
}

TEST(BallWorld, NothingIsFlownThroughAtAnySpeed) {
  Random random(1, "world/tunnel");
  const auto scene = scene_for_tests();
  for (int k = 0; k < 2000; ++k) {
    BallWorld world(with(scene, k % 2 ? Flight::paper : Flight::full));
    const double speed = std::exp(random.uniform(std::log(0.5), std::log(100.0)));
    const Vector3 on(random.uniform(-0.3, 0.3), -1.52, random.uniform(0.9, 1.7));
    Vector3 u = random_vector(random, 1.0).normalized();
    u.y() = 0.05 + std::abs(u.y());
    u.normalize();
    world.place(
        {on + random.uniform(0.03, 0.2) * u + Vector3(0, 0.021, 0), -speed * u, random_vector(random, 100)});
    for (int i = 0; i < 60; ++i) {
      world.step(0.001, far_away());
      const Vector3 p = world.ball().position;
      if (std::abs(p.x()) < 0.37 && p.z() > 0.81 && p.z() < 1.79) {
        // 20 um: the bend of a flight with strong spin within a millisecond
        ASSERT_GT(p.y(), -1.52 + game_settings(scene).ball_radius - 2e-5)
            << "case " << k << " at " << speed << " m/s";
      }
    }
  }
}

const physics::DampedContact law(0.0027, 0.80, 0.004, physics::Release::where_force_is_zero);  // of the scene

TEST(BallWorld, ASwungBatNeverLetsTheBallThroughAndKeepsItsRestitution) {
  Random random(2, "world/bat");
  auto scene = scene_for_tests();
  scene.gravity.setZero();
  int contacts = 0;
  for (int k = 0; k < 400; ++k) {
    BallWorld world(with(scene, Flight::paper));
    const double relative = std::exp(random.uniform(std::log(0.5), std::log(100.0)));
    SteadyBat bat;
    bat.rotation = so3_exp(random_vector(random, 0.4));
    bat.velocity = random_vector(random, 2.0);
    bat.start = {0, 5, 0};  // away from table and wall
    const Vector3 n = bat.normal();
    const Vector3 aim = bat.rotation * Vector3(random.uniform(-0.03, 0.03), 0, random.uniform(-0.03, 0.03));
    Vector3 u = (n + 0.3 * random_vector(random, 1.0)).normalized();
    const double lead = random.uniform(0.001, 0.01);
    world.place(
        {bat.start + aim + (0.03 + lead * relative) * u, bat.velocity - relative * u, Vector3::Zero()});
    const double dt = 0.001;
    double approach = 0.0;
    bool released = false;
    for (int i = 0; i < 40 && !released; ++i) {
      const auto motion = bat.over(i * dt, dt);
      for (const auto& touch : world.step(dt, motion)) {
        if (touch.what == Touched::bat) approach = touch.approach_speed;
        if (touch.what == Touched::bat_released) released = true;
      }
      const Vector3 local = (motion.after.inverse() * Point<World>{world.ball().position}).m;
      const double depth = approach * law.peak_penetration();
      if (local.head<1>().norm() < 0.07) {
        ASSERT_GT(local.y(), 0.006 + 0.020 - depth - 1e-6)
            << "the centre stays in front, sunk in at most as the spring says";
      }
      if (released) {
        ++contacts;
        const double leaving = n.dot(world.ball().velocity - bat.velocity);
        ASSERT_NEAR(leaving / approach, 0.80, 1e-9);
        ASSERT_NEAR(approach, relative * n.dot(u), 1e-9 * relative);
      }
    }
  }
  EXPECT_GT(contacts, 350);
}

TEST(BallWorld, TheDrawnBallSinksInAtMostThreeMillimetres) {
  auto scene = scene_for_tests();
  scene.gravity.setZero();
  BallWorld world(with(scene, Flight::paper));
  SteadyBat bat{Quaternion::Identity(), {0, 5, 0}, Vector3::Zero()};
  world.place({{0, 5.05, 0}, {0, -20, 0}, Vector3::Zero()});
  double lowest = 1.0;
  for (int i = 0; i < 200; ++i) {
    world.step(1e-4, bat.over(0, 1e-4));
    lowest = std::min(lowest, world.drawn_position().y() - 5.026);
  }
  EXPECT_LT(lowest, -0.002);
  EXPECT_GT(lowest, -BallWorld::kDrawnPenetration);
}

TEST(BallWorld, ContactLastsAsLongAsTheSceneSays) {
  auto scene = scene_for_tests();
  scene.gravity.setZero();
  BallWorld world(with(scene, Flight::paper));
  SteadyBat bat{Quaternion::Identity(), {0, 5, 0}, {0, 1, 0}};
  world.place({{0, 5.1, 0}, {0, -2, 0}, Vector3::Zero()});
  double begin = 0.0, end = 0.0, impulse = 0.0;
  const double dt = 1e-4;
  for (int i = 0; i < 500 && end == 0.0; ++i) {
    for (const auto& touch : world.step(dt, bat.over(i * dt, dt))) {
      (touch.what == Touched::bat ? begin : end) = i * dt + touch.at;
    }
    impulse += dt * world.contact_force().norm();
  }
  EXPECT_NEAR(end - begin, 0.004, 1e-9);
  EXPECT_NEAR(impulse, 0.0027 * 1.8 * 3.0, 0.01 * 0.0027 * 1.8 * 3.0);  // a sum of samples every 0.1 ms
}

TEST(BallWorld, ABatThatPressesTheBallOntoTheTableEndsTheContactThere) {
  auto scene = scene_for_tests();
  BallWorld world(with(scene, Flight::full));
  // Half a millimetre above the table, hit downwards.
  world.place({{0, -1.52 + 0.0205, 1.3}, Vector3::Zero(), Vector3::Zero()});
  const Quaternion down = Quaternion(Eigen::AngleAxisd(M_PI, Vector3::UnitX()));
  SteadyBat bat{down, {0, -1.52 + 0.0205 + 0.0265, 1.3}, {0, -1.0, 0}};
  int cut = 0, table = 0;
  for (int i = 0; i < 4; ++i) {  // then the bat would be in the table itself
    for (const auto& touch : world.step(0.001, bat.over(0.001 * i, 0.001))) {
      cut += touch.what == Touched::bat_cut_short;
      table += touch.what == Touched::table;
    }
    ASSERT_GT(world.ball().position.y(), -1.52 + 0.02 - 2e-5);
    ASSERT_LT(world.ball().velocity.norm(), 20.0);
  }
  EXPECT_GE(cut, 1);
  EXPECT_GE(table, 1);
}

TEST(BallWorld, AFrictionlessBatTouchesOnlyTheNormalComponent) {
  auto scene = scene_for_tests();
  scene.gravity.setZero();
  BallWorld world(with(scene, Flight::paper));
  SteadyBat bat{Quaternion::Identity(), {0, 5, 0}, {0.5, 0, 0.2}};
  world.place({{0, 5.05, 0}, {1, -2, -0.5}, Vector3::Zero()});
  for (int i = 0; i < 30; ++i) world.step(0.001, bat.over(0.001 * i, 0.001));
  EXPECT_NEAR((world.ball().velocity - Vector3(1, 1.6, -0.5)).norm(), 0.0, 1e-12);
}

// A bat in a hand gives way: here a mass that only the impact moves, which is what the hand is given.
struct Recoil {
  double approach = 0.0, restitution = 0.0;
  double given = 0.0;            // N s, to the hand
  double bat = 0.0, ball = 0.0;  // m/s, after
  double gained = 0.0;           // N s, by ball and bat together
};

Recoil hit_a_free_bat(scene::SceneDescription scene, double true_mass) {
  constexpr double kDt = 1e-5;
  scene.gravity.setZero();
  BallWorld world(scene);
  Vector3 place(0, 5, 0), velocity(0, 1.0, 0);
  world.place({{0, 5.05, 0}, {0, -4.0, 0}, Vector3::Zero()});
  Recoil recoil;
  bool released = false;
  for (int i = 0; i < 3000 && !released; ++i) {
    BatMotion bat;
    bat.before.translation = place;
    place += kDt * velocity;
    bat.after.translation = place;
    bat.velocity = velocity;
    for (const auto& touch : world.step(kDt, bat)) {
      if (touch.what == Touched::bat) {
        recoil.approach = touch.approach_speed;
        recoil.restitution = touch.restitution;
      }
      released = touch.what == Touched::bat_released;
    }
    velocity += kDt * world.contact_force() / true_mass;
    recoil.given -= kDt * world.contact_force().y();
  }
  EXPECT_TRUE(released);
  recoil.bat = velocity.y();
  recoil.ball = world.ball().velocity.y();
  recoil.gained = game_settings(scene).ball_mass * (recoil.ball + 4.0) + true_mass * (recoil.bat - 1.0);
  return recoil;
}

// Where the bat's mass is not said the hand is given m (1 + e) v, of which the ball, leaving relative to a
// bat that recoils all the same, keeps all but the share m / M.
TEST(BallWorld, ABatThatRecoilsTakesTheBallsMomentum) {
  constexpr double kBall = 0.0027;
  for (const auto contact :
       {scene::ContactModel::non_sticky, scene::ContactModel::paper, scene::ContactModel::hunt_crossley}) {
    for (const double M : {0.17, 0.05}) {
      const auto r = hit_a_free_bat(with(scene_for_tests(), Flight::paper, contact), M);
      const double impulse = kBall * (1 + r.restitution) * r.approach;
      EXPECT_NEAR(r.approach, 5.0, 1e-9);
      EXPECT_NEAR(r.given / impulse, 1.0, 0.005);  // a sum of samples every 10 us
      EXPECT_NEAR((r.ball - r.bat) / r.approach, r.restitution, 2e-3)
          << "relative to the bat as it moves then";
      EXPECT_NEAR(r.gained, 0.0, 1.05 * kBall / M * impulse) << M;
      EXPECT_GT(-r.gained, 0.9 * kBall / M * impulse) << "what stating the mass puts right";
    }
  }
}

// Newton (1687) for two bodies: impulse mu (1 + e) v with mu = m M / (m + M), the same for both, and the
// energy lost is mu (1 - e^2) v^2 / 2.
TEST(BallWorld, BallAndABatOfStatedMassExchangeTheImpulseOfTheirEffectiveMass) {
  constexpr double kBall = 0.0027;
  for (const auto contact :
       {scene::ContactModel::non_sticky, scene::ContactModel::paper, scene::ContactModel::hunt_crossley}) {
    for (const double M : {0.225, 0.05}) {
      const auto scene = with(with(scene_for_tests(), Flight::paper, contact), "scene.bat_mass_kg", M);
      const double mu = kBall * M / (kBall + M);
      EXPECT_NEAR(BallWorld(scene).effective_mass(), mu, 1e-15);
      const auto r = hit_a_free_bat(scene, M);
      const double impulse = mu * (1 + r.restitution) * r.approach;
      EXPECT_NEAR(r.approach, 5.0, 1e-9);
      // Sums of samples every 10 us: of the model's steps at both ends 0.3 % of the impulse may be missed.
      EXPECT_NEAR(r.given / impulse, 1.0, 0.004);
      EXPECT_NEAR(kBall * (r.ball + 4.0) / impulse, 1.0, 1e-3) << "the ball's leap is what the hand is given";
      EXPECT_NEAR(r.gained, 0.0, 0.004 * impulse);
      const auto energy = [&](double ball, double bat) {
        return 0.5 * (kBall * ball * ball + M * bat * bat);
      };
      const double lost = 0.5 * mu * (1 - r.restitution * r.restitution) * r.approach * r.approach;
      EXPECT_NEAR(energy(-4.0, 1.0) - energy(r.ball, r.bat), lost, 0.02 * energy(-5.0, 0.0));
    }
  }
}

TEST(BallWorld, ABatLighterThanTheBallIsRefused) {
  for (const double mass : {0.0027, 0.0, -1.0, std::nan("")}) {
    GameSettings game;
    game.bat_mass = mass;
    EXPECT_THROW(BallWorld(scene_for_tests(), game), std::invalid_argument) << mass;
  }
}

TEST(BallWorld, EveryContactModelKeepsItsRestitutionAndDuration) {
  struct Expected {
    scene::ContactModel model;
    double duration, restitution;
  };
  const physics::HuntCrossley hertz(0.0027, 0.80, 0.004, 5.0);
  for (const double speed : {1.0, 5.0, 12.0}) {
    for (const auto& [model, duration, restitution] :
         {Expected{scene::ContactModel::non_sticky, 0.004, 0.80},
          Expected{scene::ContactModel::paper, 0.004, 0.80},
          Expected{scene::ContactModel::hunt_crossley, hertz.contact(speed).duration(),
                   hertz.restitution(speed)}}) {
      auto scene = with(scene_for_tests(), Flight::paper, model);
      scene.gravity.setZero();
      BallWorld world(scene);
      const SteadyBat bat{Quaternion::Identity(), {0, 5, 0}, Vector3::Zero()};
      world.place({{0, 5.03, 0}, {0, -speed, 0}, Vector3::Zero()});
      double begin = -1.0, end = -1.0;
      for (int i = 0; i < 100 && end < 0.0; ++i) {
        for (const auto& touch : world.step(0.001, bat.over(0, 0.001))) {
          (touch.what == Touched::bat ? begin : end) = 0.001 * i + touch.at;
          if (touch.what != Touched::bat) continue;
          EXPECT_NEAR(touch.restitution, restitution, 1e-12);
          EXPECT_NEAR(touch.duration, duration, 1e-12);
        }
      }
      EXPECT_NEAR(end - begin, duration, 1e-9);
      EXPECT_NEAR(world.ball().velocity.y(), restitution * speed, 1e-9 * speed);
    }
  }
}

TEST(BallWorld, ASceneWithoutATableIsRefused) {
  auto scene = scene_for_tests();
  scene.surfaces.pop_back();
  EXPECT_THROW(BallWorld(with(scene, Flight::paper)), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::applications::pingpong
