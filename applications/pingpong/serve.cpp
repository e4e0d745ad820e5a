#include "applications/pingpong/serve.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "palpate/physics/flight.h"

namespace palpate::applications::pingpong {

std::vector<physics::BallState> make_serves(const scene::SceneDescription& scene, const GameSettings& game,
                                            const BallWorld& world, const ServeSettings& settings, int count,
                                            Random& random) {
  const auto& table = find_surface(scene, "table");
  const auto& wall = find_surface(scene, "wall");
  const std::array<physics::BouncePlane, 2> planes{
      physics::bounce_plane(table.corners, game.ball_radius, world.table_law()),
      physics::bounce_plane(wall.corners, game.ball_radius, world.wall_law())};
  // Axes of the table: right, up, towards the player; its near edge is corners 0 and 1, its far edge lies at
  // the wall.
  const Vector3 up = planes[0].normal;
  const Vector3 right = (table.corners[1] - table.corners[0]).normalized();
  const Vector3 near = right.cross(up);
  const Vector3 edge = 0.5 * (table.corners[0] + table.corners[1]);
  const Vector3 far = 0.5 * (table.corners[2] + table.corners[3]);
  const Vector3 aim = edge + settings.aim.x() * right + settings.aim.y() * up - settings.aim.z() * near;

  std::vector<physics::BallState> serves;
  // Fast balls cannot all come slowly and at a good height: what is asked of them is loosened step by step.
  constexpr int kLoosest = 3;
  const int tries_each = 500 * count;
  for (int i = 0; i < (kLoosest + 1) * tries_each && static_cast<int>(serves.size()) < count; ++i) {
    const int loose = i / tries_each;
    const double low = settings.height_low - 0.04 * loose, high = settings.height_high + 0.02 * loose;
    const double shortest = settings.shortest_s - 0.05 * loose, longest = settings.longest_s + 0.1 * loose;
    const double speed = random.uniform(game.serve_speed[0], game.serve_speed[1]);
    const double climb = random.uniform(-0.5, 1.2);  // rad
    // One after the other: a sum's terms are drawn in an order that is the compiler's.
    const double before = random.uniform(0.04, 0.08), above = random.uniform(0.10, 0.42),
                 aside = random.uniform(-0.12, 0.12);
    const Vector3 from = far + aside * right + above * up + (game.ball_radius + before) * near;
    const Vector3 to = aim + settings.aim_sd * std::clamp(random.normal(), -2.0, 2.0) * right;
    const Vector3 along = (to - from) - up.dot(to - from) * up;
    physics::BallState ball{from, speed * (std::cos(climb) * along.normalized() + std::sin(climb) * up),
                            Vector3::Zero()};
    const physics::BallState serve = ball;
    int bounces = 0;
    double t = 0.0;
    constexpr double kStep = 0.004;
    while (t < longest && near.dot(ball.position - to) < 0.0 && bounces < 2) {
      bounces += physics::advance(world.model(), planes, ball, kStep);
      t += kStep;
    }
    const double height = up.dot(ball.position - edge);
    if (bounces == 1 && near.dot(ball.position - to) >= 0.0 && t >= shortest && height >= low &&
        height <= high) {
      serves.push_back(serve);
    }
  }
  if (static_cast<int>(serves.size()) < count) {
    throw std::runtime_error(fmt::format(
        "pingpong: only {} of {} serves of {} to {} m/s bounce once and reach the player on this table; "
        "check the surfaces' corners or widen serve_speed",
        serves.size(), count, game.serve_speed[0], game.serve_speed[1]));
  }
  return serves;
}

}  // namespace palpate::applications::pingpong
