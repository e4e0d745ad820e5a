// Ball states of real rallies and serves (data/rally_starts), each played for ten seconds on a table of the
// rules' size with a wall behind it, with air, spin and friction: no ball comes inside or behind anything.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "palpate/applications/pingpong/ball_world.h"
#include "palpate/core/file.h"

namespace palpate::pingpong {
namespace {

std::vector<BallState> rally_starts(const char* name) {
  const auto content = read_file(std::filesystem::path(PALPATE_DATA_DIR) / "rally_starts" / name);
  std::vector<BallState> all;
  if (!content) return all;
  for (std::size_t at = content->find('\n') + 1; at > 0 && at < content->size();
       at = content->find('\n', at) + 1) {
    int id = 0;
    double p[3], v[3], w[3];
    if (std::sscanf(content->c_str() + at, "%d,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", &id, p, p + 1, p + 2, v,
                    v + 1, v + 2, w, w + 1, w + 2) != 10)
      break;
    // Their z is up, ours y.
    all.push_back({{p[0], p[2], -p[1]}, {v[0], v[2], -v[1]}, {w[0], w[2], -w[1]}});
    if (content->find('\n', at) == std::string::npos) break;
  }
  return all;
}

// A rectangle, asked without the sweep: how far the centre is, and whether a step went through.
struct Plate {
  Vector3 corner, x, y;
  Vector3 normal() const { return x.cross(y).normalized(); }
  double distance(const Vector3& p) const {
    const double u = std::clamp((p - corner).dot(x) / x.squaredNorm(), 0.0, 1.0);
    const double v = std::clamp((p - corner).dot(y) / y.squaredNorm(), 0.0, 1.0);
    return (p - corner - u * x - v * y).norm();
  }
  bool crossed(const Vector3& from, const Vector3& to) const {
    const double a = normal().dot(from - corner), b = normal().dot(to - corner);
    if (a * b >= 0.0) return false;
    const Vector3 p = from + a / (a - b) * (to - from) - corner;
    const double u = p.dot(x) / x.squaredNorm(), v = p.dot(y) / y.squaredNorm();
    return u > 0.0 && u < 1.0 && v > 0.0 && v < 1.0;
  }
};

TEST(RallyStarts, TenSecondsOfEveryRealHitEndOutsideOfEverything) {
  SceneDescription scene;
  const Plate table{{-0.7625, 0, 1.37}, {1.525, 0, 0}, {0, 0, -2.74}};
  const Plate wall{{1.5, -0.76, 2.2}, {-3.0, 0, 0}, {0, 3.0, 0}};
  for (const auto& [name, plate] : {std::pair{"table", table}, {"wall", wall}})
    scene.surfaces.push_back({name,
                              {plate.corner, Vector3(plate.corner + plate.x),
                               Vector3(plate.corner + plate.x + plate.y), Vector3(plate.corner + plate.y)},
                              0.93});
  BatMotion away;
  away.before.translation = away.after.translation = {0, 500, 0};
  std::size_t played = 0, touches = 0, stopped = 0;
  for (const char* name : {"rallies.csv", "serves.csv"}) {
    for (const auto& start : rally_starts(name)) {
      ++played;
      BallWorld world(scene, Physics::full);
      world.place(start);
      bool touched = false;
      for (int i = 0; i < 10000; ++i) {
        const Vector3 before = world.ball().position;
        for (const auto& touch : world.step(0.001, away, false)) {
          touched = true;
          ++touches;
          stopped += touch.what == Touched::squeezed;
        }
        const Vector3 p = world.ball().position;
        if (p.y() < -3.0) break;  // fell past the table: nothing is left to meet
        if (!touched) continue;
        for (const auto* plate : {&table, &wall}) {
          ASSERT_FALSE(plate->crossed(before, p)) << name << ' ' << played;
          // 20 um: the bend of a flight with strong spin within a millisecond
          ASSERT_GT(plate->distance(p), scene.ball_radius - 2e-5) << name << ' ' << played << " step " << i;
        }
      }
    }
  }
  EXPECT_EQ(played, 7896u);
  EXPECT_GT(touches, 10000u);
  RecordProperty("stopped", std::to_string(stopped));
}

}  // namespace
}  // namespace palpate::pingpong
