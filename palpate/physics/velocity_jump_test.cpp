#include "palpate/physics/velocity_jump.h"

#include <gtest/gtest.h>

#include <string>

#include "palpate/math/random_vector.h"
#include "palpate/physics/flight_file.h"

namespace palpate::physics {
namespace {

BallModel z_up() {
  BallModel model;
  model.gravity = {0, 0, -9.81};
  return model;
}

BouncePlane table_top(double restitution) {
  BouncePlane plane;
  plane.point = {0, 0, 0.78};
  plane.normal = Vector3::UnitZ();
  plane.law = {restitution, 0.25};
  return plane;
}

struct Game {  // down to the table, struck at 0.75 s, to the table again
  std::vector<SeenBall> seen;
  std::vector<double> jumps;
};

Game played(double restitution, double noise, std::uint64_t seed) {
  Random random(seed, "velocity_jump/game");
  const auto model = z_up();
  const auto table = table_top(restitution);
  BallState ball{{0.0, 3.0, 1.3}, {0.2 + random.uniform(0.0, 0.3), -3.6, 0.6}, Vector3::Zero()};
  constexpr double kStep = 0.0002, kStruckAt = 0.75;
  Game game;
  double next = 0.0;
  for (double t = 0.0; t < 1.6; t += kStep) {
    if (t >= next) {
      game.seen.push_back({t, ball.position + normal3(random, noise)});
      next += 1.0 / 180.0;
    }
    const bool struck = t <= kStruckAt && kStruckAt < t + kStep;
    if (struck) ball.velocity = {0.4, 4.5, 2.0};  // the spin it has from the table bends its flight
    if (struck || advance(model, {&table, 1}, ball, kStep) > 0) game.jumps.push_back(t + 0.5 * kStep);
  }
  return game;
}

TEST(VelocityJump, EveryBounceAndImpactIsFoundWhereItWas) {
  for (const double noise : {0.0, 0.003, 0.005}) {
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      const auto game = played(0.92, noise, seed);
      const auto jumps = find_velocity_jumps({0, 0, -9.81}, game.seen);
      ASSERT_EQ(game.jumps.size(), 3u);
      ASSERT_EQ(jumps.size(), 3u) << "noise " << noise << " seed " << seed;
      for (std::size_t i = 0; i < 3; ++i)  // two places off by 5 mm meet at 6 m/s: a millisecond
        EXPECT_NEAR(jumps[i].time, game.jumps[i], 0.0003 + 1.5 * noise)
            << "noise " << noise << " seed " << seed;
      for (const std::size_t i : {0u, 2u}) {
        EXPECT_TRUE(bounced_on_resting_surface(jumps[i], Vector3::UnitZ())) << "noise " << noise;
        // The bend itself changes along a flight with spin, which shows as up to 0.014.
        // Flights of 0.2 s with 36 places tell a velocity at their end to 8 times noise per second.
        EXPECT_NEAR(restitution_of(jumps[i], Vector3::UnitZ()), 0.92, 0.016 + 15.0 * noise);
        EXPECT_NEAR(jumps[i].place.z(), 0.78, 0.001 + 3.0 * noise);
      }
      EXPECT_FALSE(bounced_on_resting_surface(jumps[1], Vector3::UnitZ())) << "the bat was no table";
    }
  }
}

TEST(VelocityJump, ManyNoisyBouncesGiveTheRestitutionOnAverage) {
  double sum = 0.0;
  int bounces = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    for (const auto& jump : find_velocity_jumps({0, 0, -9.81}, played(0.88, 0.005, seed).seen)) {
      if (!bounced_on_resting_surface(jump, Vector3::UnitZ())) continue;
      sum += restitution_of(jump, Vector3::UnitZ());
      ++bounces;
    }
  }
  EXPECT_EQ(bounces, 400);
  EXPECT_NEAR(sum / bounces, 0.88, 0.016);  // the same change of bend; chance leaves 0.002 of the mean
}

TEST(VelocityJump, AFreeFlightHasNone) {
  const auto model = z_up();
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Random random(seed, "velocity_jump/free");
    BallState ball{{0, 0, 1}, {4, 1, 3}, {0, 120, 0}};
    std::vector<SeenBall> seen;
    for (int i = 0; i < 90; ++i) {
      seen.push_back({i / 180.0, ball.position + normal3(random, 0.005)});
      for (int k = 0; k < 5; ++k) ball = fly(model, ball, 1.0 / 900.0);
    }
    EXPECT_TRUE(find_velocity_jumps({0, 0, -9.81}, seen).empty()) << seed;
  }
}

TEST(VelocityJump, TooLittleSeenShowsNothing) {
  const auto game = played(0.9, 0.0, 1);
  EXPECT_TRUE(find_velocity_jumps({0, 0, -9.81}, {}).empty());
  EXPECT_TRUE(find_velocity_jumps({0, 0, -9.81}, {game.seen.data(), 9}).empty());
}

TEST(VelocityJump, ABounceIsSlowerThanItsFallAndIsNotDragged) {
  const auto jump = [](const Vector3& before, const Vector3& after) {
    VelocityJump made;
    made.before = before;
    made.after = after;
    return made;
  };
  const auto bounce = jump({1, 0, -3}, {0.8, 0, 2.7}), faster = jump({1, 0, -3}, {1, 0, 3.1}),
             thrown = jump({1, 0, -3}, {-3, 0, 2.7}), falling = jump({1, 0, -3}, {1, 0, -1});
  EXPECT_TRUE(bounced_on_resting_surface(bounce, Vector3::UnitZ()));
  EXPECT_DOUBLE_EQ(restitution_of(bounce, Vector3::UnitZ()), 0.9);
  for (const auto& other : {faster, thrown, falling})
    EXPECT_FALSE(bounced_on_resting_surface(other, Vector3::UnitZ()));
}

TEST(VelocityJump, RecordedFlightsBounceOnceOnTheirTable) {
  for (const auto* name :
       {"no_spin_robot_simple_000", "no_spin_robot_simple_006", "no_spin_robot_simple_010"}) {
    const auto seen = read_flight(std::string(PALPATE_DATA_DIR) + "/flights/" + name + ".csv");
    ASSERT_TRUE(seen) << seen.error().message;
    const auto jumps = find_velocity_jumps({0, 0, -9.81}, *seen);
    ASSERT_EQ(jumps.size(), 1u) << name;
    EXPECT_TRUE(bounced_on_resting_surface(jumps[0], Vector3::UnitZ())) << name;
    EXPECT_NEAR(jumps[0].place.z(), 0.760, 0.006) << name;  // their origin states 0.760; places to 3 mm
    EXPECT_NEAR(restitution_of(jumps[0], Vector3::UnitZ()), 0.93, 0.05) << name;
  }
}

TEST(VelocityJump, ARobotsReturnIsABounceAnImpactAndABounce) {
  for (const auto* name : {"robot_return_002", "robot_return_004", "robot_return_008"}) {
    const auto seen = read_flight(std::string(PALPATE_DATA_DIR) + "/robot_returns/" + name + ".csv");
    ASSERT_TRUE(seen) << seen.error().message;
    const auto jumps = find_velocity_jumps({0, 0, -9.81}, *seen);
    ASSERT_GE(jumps.size(), 3u) << name;
    EXPECT_TRUE(bounced_on_resting_surface(jumps[0], Vector3::UnitZ())) << name;
    EXPECT_NEAR(jumps[0].place.z(), 0.782, 0.012) << name;
    EXPECT_LT(jumps[0].after.y(), 0.0) << name;
    EXPECT_FALSE(bounced_on_resting_surface(jumps[1], Vector3::UnitZ())) << name;
    EXPECT_GT(jumps[1].after.y(), 1.0) << name << ": struck back";
  }
}

}  // namespace
}  // namespace palpate::physics
