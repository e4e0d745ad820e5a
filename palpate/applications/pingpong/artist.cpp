#include "palpate/applications/pingpong/artist.h"

#include <fmt/format.h>

#include "palpate/applications/pingpong/pingpong.h"

namespace palpate::pingpong {
namespace {

// Half of the blade, front (+y) or back, in the Bat frame.
TriangleMesh half_blade(const SceneDescription& scene, double side) {
  auto mesh = disc_mesh(scene.bat_radius, 0.5 * BallWorld::kBatThickness, 48);
  for (auto& v : mesh.vertices) v.y() += side * 0.25 * BallWorld::kBatThickness;
  return mesh;
}

}  // namespace

PingPongArtist::PingPongArtist(const SceneDescription& scene)
    : ball_(sphere_mesh(scene.ball_radius)), front_(half_blade(scene, 1.0)), back_(half_blade(scene, -1.0)) {
  // From the stylus tip to a little inside the blade; the tip is where the bat's offset leads back to.
  constexpr double kHandleRadius = 0.011, kInside = 0.010;
  const Vector3 tip = -scene.bat_offset;
  const double reach = tip.norm();
  if (reach > scene.bat_radius - kInside) {
    handle_ = cylinder_mesh(tip, (scene.bat_radius - kInside) / reach * tip, kHandleRadius);
  }
}

std::vector<DrawItem> PingPongArtist::draw(const WorldState& state) const {
  std::vector<DrawItem> items;
  const auto& ball = state.bodies[kBall];
  if (state.body_count > kBall && ball.visible != 0)
    items.push_back({&ball_, Material::ball, ball.q(), ball.p(), true});
  const auto& bat = state.bodies[kBat];
  if (state.body_count > kBat && bat.visible != 0) {
    items.push_back({&front_, Material::bat_front, bat.q(), bat.p(), true});
    items.push_back({&back_, Material::bat_back, bat.q(), bat.p(), true});
    if (!handle_.triangles.empty()) items.push_back({&handle_, Material::handle, bat.q(), bat.p(), true});
  }
  return items;
}

std::vector<std::string> PingPongArtist::captions(const WorldState& state) const {
  const auto& c = state.counters;
  return {fmt::format("returned {} of {}", c[kReturned], c[kServes]),
          fmt::format("rally {}   longest {}", c[kRally], c[kLongest])};
}

}  // namespace palpate::pingpong
