// Balls as they left bats in recorded rallies and serves (data/ball_starts), played for ten seconds each.
// Another folder with rallies.csv and serves.csv of the same form is played where PALPATE_BALL_STARTS names
// it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "applications/pingpong/ball_world.h"
#include "applications/pingpong/scene_for_tests.h"
#include "palpate/core/csv.h"

namespace palpate::applications::pingpong {
namespace {

constexpr double kPlayedTick = 0.001, kPlayed_s = 10.0;
constexpr double kBallRadius = 0.020;
constexpr double kBatRadius = 0.25;  // larger than life, so that many balls meet it

// A full-size table, top at y = 0, with a wall across its far end at z = -1.37.
scene::SceneDescription hall(Flight flight) {
  scene::SceneDescription scene = with(with(scene_for_tests(), flight), "scene.bat_radius_m", kBatRadius);
  constexpr double x = 0.7625, z = 1.37, h = 1.5;
  scene.surfaces[0].corners = {Vector3(-x, 0, z), Vector3(x, 0, z), Vector3(x, 0, -z), Vector3(-x, 0, -z)};
  scene.surfaces[1].corners = {Vector3(-x, 0, -z), Vector3(x, 0, -z), Vector3(x, h, -z), Vector3(-x, h, -z)};
  return scene;
}

std::vector<physics::BallState> starts() {
  const char* folder = std::getenv("PALPATE_BALL_STARTS");
  std::vector<physics::BallState> balls;
  for (const char* name : {"rallies", "serves"}) {
    const auto table =
        read_csv((folder ? std::string(folder) : std::string(PALPATE_DATA_DIR) + "/ball_starts") + "/" +
                 name + ".csv");
    if (!table) {
      ADD_FAILURE() << table.error().message;
      continue;
    }
    for (const auto& r : table->rows) {
      const auto turned = [&](std::size_t i) { return Vector3(r[i], r[i + 2], -r[i + 1]); };  // z up -> y up
      physics::BallState ball{turned(1), turned(4), turned(7)};
      if (ball.velocity.z() > 0.0) {  // all towards the wall
        const Quaternion round(Eigen::AngleAxisd(M_PI, Vector3::UnitY()));
        ball = {round * ball.position, round * ball.velocity, round * ball.spin};
      }
      balls.push_back(ball);
    }
  }
  return balls;
}

// Swings to and fro in front of the player and turns while it does, up to 3 m/s; never reaches table or wall.
Pose<World, Bat> bat_at(double t) {
  const Quaternion tilt =
      so3_exp(Vector3(1.2 + 0.3 * std::sin(5.0 * t), 0.2 * std::sin(3.0 * t), 0.3 * std::cos(4.0 * t)));
  return {tilt,
          Vector3(0.4 * std::sin(4.0 * t), 0.45 + 0.1 * std::sin(7.0 * t), 1.2 + 0.3 * std::sin(6.0 * t))};
}

BatMotion swing(double t) {
  BatMotion bat;
  bat.before = bat_at(t);
  bat.after = bat_at(t + kPlayedTick);
  bat.velocity = (bat.after.translation - bat.before.translation) / kPlayedTick;
  bat.angular_velocity = so3_log(bat.after.rotation * bat.before.rotation.conjugate()) / kPlayedTick;
  return bat;
}

struct Played {
  int table = 0, wall = 0, bat = 0, squeezed = 0;
  double deepest = 0.0, most_crossed = 0.0;
};

// How deep the ball is in a rectangle; by brute force, without the code that moves it.
double depth_in(const std::array<Vector3, 4>& c, const Vector3& p, double radius) {
  double nearest = 1e9;
  for (const physics::Triangle& t :
       {physics::Triangle{c[0], c[1], c[2]}, physics::Triangle{c[0], c[2], c[3]}})
    nearest = std::min(nearest, (physics::closest_point(t, p) - p).norm());
  return radius - nearest;
}

bool crosses(const std::array<Vector3, 4>& c, const Vector3& from, const Vector3& to) {
  const Vector3 n = (c[1] - c[0]).cross(c[3] - c[0]).normalized();
  const double a = n.dot(from - c[0]), b = n.dot(to - c[0]);
  if ((a > 0.0) == (b > 0.0)) return false;
  const Vector3 at = from + a / (a - b) * (to - from) - c[0];
  const Vector3 x = c[1] - c[0], y = c[3] - c[0];
  const double u = at.dot(x) / x.squaredNorm(), v = at.dot(y) / y.squaredNorm();
  return u >= 0.0 && u <= 1.0 && v >= 0.0 && v <= 1.0;
}

// The same in the bat, in its frame.
double depth_in_bat(const scene::TriangleMesh& bat, const Vector3& local, double radius) {
  if (local.norm() > kBatRadius + 2.0 * radius) return -radius;
  double nearest = 1e9;
  for (const auto& t : bat.triangles) {
    const physics::Triangle triangle{bat.vertices[t[0]], bat.vertices[t[1]], bat.vertices[t[2]]};
    nearest = std::min(nearest, (physics::closest_point(triangle, local) - local).norm());
  }
  return radius - nearest;
}

Played play(const physics::BallState& start, Flight flight, std::size_t number) {
  const auto scene = hall(flight);
  BallWorld world(scene);
  const auto mesh = scene::disc_mesh(kBatRadius, BallWorld::kBatThickness, 32);
  world.place(start);
  Played played;
  double free_since = 0.0;
  bool bat_is_there = false;
  for (int i = 0; i < static_cast<int>(kPlayed_s / kPlayedTick); ++i) {
    const double t = i * kPlayedTick;
    const auto bat = swing(t + 0.1 * static_cast<double>(number));
    const Vector3 before = world.ball().position;
    // The bat comes into play where the ball is not in its way already.
    const bool was_there = bat_is_there;
    bat_is_there = bat_is_there || (before - bat.before.translation).norm() > kBatRadius + 0.1;
    for (const auto& touch : world.step(kPlayedTick, bat, bat_is_there)) {
      played.table += touch.what == Touched::table;
      played.wall += touch.what == Touched::wall;
      played.bat += touch.what == Touched::bat;
      played.squeezed += touch.what == Touched::squeezed;
      // The spring is still recovering when the ball leaves it.
      if (touch.what != Touched::table && touch.what != Touched::wall) free_since = t + 0.003;
    }
    if (world.in_contact()) free_since = t + 0.003;
    const Vector3 now = world.ball().position;
    EXPECT_TRUE(now.allFinite());
    for (const auto& surface : scene.surfaces) {
      EXPECT_FALSE(crosses(surface.corners, before, now))
          << surface.name << " ball " << number << " at " << t;
      played.deepest = std::max(played.deepest, depth_in(surface.corners, now, kBallRadius));
    }
    if (!bat_is_there || !was_there) continue;
    const Vector3 from = (bat.before.inverse() * Point<World>{before}).m;
    const Vector3 to = (bat.after.inverse() * Point<World>{now}).m;
    if ((from.y() > 0.0) != (to.y() > 0.0)) {
      const Vector3 at = from + from.y() / (from.y() - to.y()) * (to - from);
      EXPECT_GT(Vector3(at.x(), 0.0, at.z()).norm(), 0.995 * kBatRadius)
          << "through the bat, ball " << number << " at " << t;
    }
    if (t >= free_since) {
      EXPECT_LT(depth_in_bat(mesh, to, kBallRadius), 3e-4) << "in the bat, ball " << number << " at " << t;
    }
    if (now.y() < -20.0) break;  // gone for good
  }
  return played;
}

TEST(BallStartsStatistics, NoBallOfARallyEndsInsideOrBehindAnything) {
  const auto balls = starts();
  ASSERT_GT(balls.size(), 400u);
  Played all;
  for (const auto flight : {Flight::full, Flight::paper}) {
    for (std::size_t i = 0; i < balls.size(); ++i) {
      const auto one = play(balls[i], flight, i);
      all.table += one.table;
      all.wall += one.wall;
      all.bat += one.bat;
      all.squeezed += one.squeezed;
      all.deepest = std::max(all.deepest, one.deepest);
      if (testing::Test::HasFailure()) FAIL() << "ball " << i;
    }
  }
  // The path within a step is straight: it may miss by the bend of a flight, (10 + 2 v w R) dt^2 / 8.
  EXPECT_LT(all.deepest, 3e-5);
  const auto n = static_cast<int>(balls.size());
  EXPECT_GT(all.table, n);
  EXPECT_GT(all.wall, n / 2);
  EXPECT_GT(all.bat, n / 4);
  std::printf(
      "%d balls: %d bounces on the table, %d on the wall, %d on the bat, %d squeezed, deepest %.1f um\n",
      2 * n, all.table, all.wall, all.bat, all.squeezed, 1e6 * all.deepest);
}

}  // namespace
}  // namespace palpate::applications::pingpong
