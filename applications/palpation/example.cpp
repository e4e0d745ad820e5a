#include "applications/palpation/example.h"

#include <algorithm>
#include <cmath>

#include "applications/palpation/liver.h"
#include "applications/palpation/palpation.h"
#include "applications/palpation/settings.h"

namespace palpate::applications::palpation {
namespace {

// Of the upper side, where the camera sees it best: between its middle and the person.
Vector3 pressed_place(const scene::TriangleMesh& organ) {
  const SearchArea area = search_area(organ);
  const Vector3 wanted(area.centre_x - 0.35 * area.half_x, 0.0, area.centre_z + 0.35 * area.half_z);
  const auto aside = [&](const Vector3& v) { return std::hypot(v.x() - wanted.x(), v.z() - wanted.z()); };
  constexpr double kUnderside_m = 0.005;
  Vector3 nearest = organ.vertices.front();
  for (const auto& v : organ.vertices)
    if (v.y() > kUnderside_m && (nearest.y() <= kUnderside_m || aside(v) < aside(nearest))) nearest = v;
  return nearest;
}

}  // namespace

scene::SceneState example_state(const scene::SceneDescription& scene, const Pose<World, Tip>&) {
  constexpr double kLean_rad = 1.2;
  const PalpationSettings settings = palpation_settings(scene);
  const Pose<World, Body> X_world_body = resting_place(scene);
  const double depth = std::min(settings.deepest, 0.9 * settings.tip_radius);
  const Vector3 tip = pressed_place(pressed_mesh(scene)) + (settings.tip_radius - depth) * Vector3::UnitY();
  scene::SceneState state;
  state.body_count = kTip + 1;
  for (const int body : {kOrgan, kStylus, kTip}) {
    auto& b = state.bodies[static_cast<std::size_t>(body)];
    b.set_p(body == kOrgan ? X_world_body.translation : (X_world_body * Point<Body>{tip}).m);
    b.set_q(body == kOrgan
                ? X_world_body.rotation
                : X_world_body.rotation * Quaternion(Eigen::AngleAxisd(-kLean_rad, Vector3::UnitX())));
  }
  state.counters[kPhase] = static_cast<std::int32_t>(TrialPhase::searching);
  state.counters[kDepthUm] = static_cast<std::int32_t>(std::lround(1e6 * depth));
  state.continuous.touching = 1;
  const Vector3 touched =
      state.bodies[kTip].p() - settings.tip_radius * (X_world_body.rotation * Vector3::UnitY());
  state.continuous.point = {touched.x(), touched.y(), touched.z()};
  return state;
}

std::vector<float> example_shape(const scene::SceneDescription& scene, const scene::SceneState& state) {
  PalpationApplication application(scene, {.keeps_files = false}, cache_folder());
  constexpr Duration kTick = std::chrono::milliseconds(1);
  scene::TipState tip;
  tip.X_world_tip = {state.bodies[kTip].q(), state.bodies[kTip].p()};
  const Vector3 up = application.rest().rotation * Vector3::UnitY();
  scene::SceneState shown;
  constexpr int kTicks = 400;
  constexpr double kFrom_m = 0.02;
  for (int i = 0; i < 2 * kTicks; ++i) {  // down, and held
    tip.time = Instant<PhysicsClock>{(i + 1) * kTick};
    tip.X_world_tip.translation =
        state.bodies[kTip].p() + kFrom_m * std::max(0.0, 1.0 - static_cast<double>(i) / kTicks) * up;
    application.contact_law()->force(tip, to_seconds(kTick));
    application.step(tip.time, kTick, tip, shown);
  }
  return {application.shape().begin(), application.shape().end()};
}

}  // namespace palpate::applications::palpation
