#include "applications/pingpong/scene_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "applications/pingpong/ball_world.h"
#include "applications/pingpong/looks.h"
#include "applications/pingpong/pingpong.h"
#include "palpate/core/text.h"

namespace palpate::applications::pingpong {
namespace {

constexpr double kPredictionStep = 0.002;  // s

// Half of the blade, front (+y) or back, in the Bat frame.
scene::TriangleMesh half_blade(const GameSettings& game, double side) {
  auto mesh = scene::disc_mesh(game.bat_radius, 0.5 * BallWorld::kBatThickness, 48);
  for (auto& v : mesh.vertices) v.y() += side * 0.25 * BallWorld::kBatThickness;
  return mesh;
}

constexpr double kRimRadius_m = 0.004, kStringRadius_m = 0.0006, kStringsApart_m = 0.015;

// In the blade's plane, in the Bat frame.
scene::TriangleMesh strings_of(const GameSettings& game) {
  const double within = game.bat_radius - kRimRadius_m;
  const int each_side = static_cast<int>((within - kRimRadius_m) / kStringsApart_m);
  scene::TriangleMesh mesh;
  for (int i = -each_side; i <= each_side; ++i) {
    const double x = i * kStringsApart_m, z = std::sqrt(within * within - x * x);
    scene::append(mesh, scene::cylinder_mesh({x, 0.0, -z}, {x, 0.0, z}, kStringRadius_m, 6));
    scene::append(mesh, scene::cylinder_mesh({-z, 0.0, x}, {z, 0.0, x}, kStringRadius_m, 6));
  }
  return mesh;
}

std::string points_text(std::int32_t points) {
  return counted(static_cast<std::size_t>(std::max(points, 0)), "point");
}

}  // namespace

PingPongView::PingPongView(const scene::SceneDescription& scene)
    : scene_(scene),
      game_(game_settings(scene)),
      ball_(scene::sphere_mesh(game_.ball_radius)),
      front_(half_blade(game_, 1.0)),
      back_(half_blade(game_, -1.0)),
      rim_(scene::ring_mesh(game_.bat_radius - kRimRadius_m, kRimRadius_m)),
      strings_(strings_of(game_)) {
  // From the stylus tip to a little inside the blade; the tip is where the bat's offset leads back to.
  constexpr double kHandleRadius = 0.011, kInside = 0.010;
  const Vector3 tip = -scene.carried_offset;
  const double reach = tip.norm();
  if (reach > game_.bat_radius - kInside) {
    handle_ = scene::cylinder_mesh(tip, (game_.bat_radius - kInside) / reach * tip, kHandleRadius);
  }
}

std::vector<scene::DrawItem> PingPongView::draw(const scene::SceneState& state) const {
  std::vector<scene::DrawItem> items;
  const auto& ball = state.bodies[kBall];
  if (state.body_count > kBall && ball.visible != 0)
    items.push_back({&ball_, kBallLook, ball.q(), ball.p(), true, game_.ball_radius});
  const auto& bat = state.bodies[kBat];
  if (state.body_count > kBat && bat.visible != 0) {
    items.push_back({strung_ ? &rim_ : &front_, kFrontLook, bat.q(), bat.p(), true});
    items.push_back(strung_ ? scene::DrawItem{&strings_, kStringLook, bat.q(), bat.p(), true}
                            : scene::DrawItem{&back_, kBackLook, bat.q(), bat.p(), true});
    if (!handle_.triangles.empty()) items.push_back({&handle_, kHandleLook, bat.q(), bat.p(), true});
  }
  return items;
}

scene::SceneState PingPongView::predict(const scene::SceneState& state, Duration ahead) const {
  scene::SceneState next = scene::extrapolate(state, ahead);
  const auto named = [this](const char* name) {
    return std::any_of(scene_.surfaces.begin(), scene_.surfaces.end(),
                       [name](const scene::SceneSurface& s) { return s.name == name; });
  };
  const double span = to_seconds(ahead);
  if (state.body_count <= kBat || state.bodies[kBall].visible == 0 || span <= 0.0) return next;
  if (!named("table") || !named("wall")) return next;
  const scene::BodyState &ball_before = state.bodies[kBall], &bat_before = state.bodies[kBat];
  scene::BodyState& ball_after = next.bodies[kBall];
  const Vector3 velocity = bat_before.v(), turning(bat_before.angular_velocity.data());
  const auto bat_at = [&](double t) {
    return Pose<World, Bat>{(so3_exp(t * turning) * bat_before.q()).normalized(),
                            bat_before.p() + t * velocity};
  };
  // From a contact with the bat on the ball goes where the bat goes.
  const auto stay_on_bat = [&](const Vector3& ball, double t) {
    const Point<Bat> place = bat_at(t).inverse() * Point<World>{ball};
    ball_after.set_p((bat_at(span) * place).m);
    ball_after.set_v(velocity);
  };
  if (state.impact.share > 0.0) {
    stay_on_bat(ball_before.p(), 0.0);
    return next;
  }
  BallWorld world(scene_, game_);
  world.place({ball_before.p(), ball_before.v(), Vector3(ball_before.angular_velocity.data())});
  double t = 0.0;
  while (t < span) {
    const double dt = std::min(kPredictionStep, span - t);
    const physics::BallState before = world.ball();
    const auto touches = world.step(dt, {bat_at(t), bat_at(t + dt), velocity, turning});
    if (!touches.empty()) {
      const Vector3 met = physics::fly(world.model(), before, touches.front().at).position;
      if (touches.front().what == Touched::table || touches.front().what == Touched::wall) {
        ball_after.set_p(met);
        ball_after.set_v(Vector3::Zero());
      } else {
        stay_on_bat(met, t + touches.front().at);
      }
      return next;
    }
    t += dt;
  }
  ball_after.set_p(world.ball().position);
  ball_after.set_v(world.ball().velocity);
  return next;
}

std::vector<std::string> PingPongView::captions(const scene::SceneState& state) const {
  const auto& c = state.counters;
  if (c[kLevel] < 0)
    return {"match over: " + points_text(c[kPoints]),
            fmt::format("{} of {} returned, best match {}", c[kMatchReturned], c[kMatchServes],
                        points_text(c[kBest])),
            fmt::format("level {} next", -c[kLevel])};
  if (c[kLevel] > 0)
    return {
        points_text(c[kPoints]),
        fmt::format("serve {} of {}, {} returned", c[kMatchServes], game_.match.serves, c[kMatchReturned]),
        fmt::format("level {}{}", c[kLevel], c[kBest] > 0 ? ", best match " + points_text(c[kBest]) : "")};
  return {fmt::format("serves returned {} of {}", c[kReturned], c[kServes]),
          fmt::format("returns in a row {}", c[kRally]), fmt::format("most in a row {}", c[kLongest])};
}

}  // namespace palpate::applications::pingpong
