#include "applications/palpation/scene_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "applications/palpation/looks.h"
#include "applications/palpation/palpation.h"

namespace palpate::applications::palpation {
namespace {

constexpr double kStylusLength_m = 0.13, kStylusRadius_m = 0.0028;
constexpr double kMarkRadius_m = 0.0028, kOnTop_m = 0.0012;

// Every vertex, and of the triangles those near a grid's lines: what lies inside is seen between them.
scene::TriangleMesh net_of(const scene::TriangleMesh& organ) {
  constexpr double kMesh_m = 0.010, kThread_m = 0.0011;
  const auto near_line = [](double x) { return std::abs(std::remainder(x, kMesh_m)) < kThread_m; };
  scene::TriangleMesh net;
  net.vertices = organ.vertices;
  for (const auto& t : organ.triangles) {
    const Vector3 middle = (organ.vertices[t[0]] + organ.vertices[t[1]] + organ.vertices[t[2]]) / 3.0;
    if (near_line(middle.x()) || near_line(middle.z())) net.triangles.push_back(t);
  }
  return net;
}

// All of it but the underside, which nobody sees: half as much to draw.
scene::TriangleMesh upper_side(const scene::TriangleMesh& organ) {
  constexpr double kUnderside_m = 0.0002;
  scene::TriangleMesh upper;
  upper.vertices = organ.vertices;
  for (const auto& t : organ.triangles)
    if (std::any_of(t.begin(), t.end(),
                    [&](std::uint32_t i) { return organ.vertices[i].y() > kUnderside_m; }))
      upper.triangles.push_back(t);
  return upper;
}

// What the organ lies on, where it is lifted off the table; a box in the frame Body.
scene::TriangleMesh tray_under(const scene::TriangleMesh& organ, double up) {
  constexpr double kLeast_m = 0.001, kRim_m = 0.008;
  if (up < kLeast_m) return {};
  Vector3 low = organ.vertices.front(), high = low;
  for (const auto& v : organ.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return scene::box_mesh({low.x() - kRim_m, -up, low.z() - kRim_m},
                         {high.x() + kRim_m, 0.0, high.z() + kRim_m});
}

bool is_shown(const scene::SceneState& state) {
  return state.counters[kPhase] == static_cast<std::int32_t>(TrialPhase::shown);
}

}  // namespace

const std::vector<HiddenNodule>& RevealedNodules::of(const scene::SceneState& state) {
  const std::int32_t seed = state.counters[kNoduleSeed];
  if (seed == seed_) return nodules_;
  seed_ = seed;
  nodules_.clear();
  if (seed <= 0) return nodules_;
  if (auto drawn = draw_nodules(organ_, settings_, seed)) nodules_ = *drawn;
  return nodules_;
}

std::vector<Vector3> marks_of(const scene::SceneState& state) {
  std::vector<Vector3> marks;
  const auto& organ = state.bodies[kOrgan];
  for (int i = kFirstMark; i < std::min(state.body_count, kFirstMark + static_cast<int>(kMostMarks)); ++i) {
    const auto& mark = state.bodies[static_cast<std::size_t>(i)];
    if (mark.visible != 0) marks.push_back(organ.q().conjugate() * (mark.p() - organ.p()));
  }
  return marks;
}

PalpationView::PalpationView(const scene::SceneDescription& scene)
    : settings_(palpation_settings(scene)),
      X_world_rest_(resting_place(scene)),
      organ_(pressed_mesh(scene)),
      seen_(upper_side(organ_)),
      net_(net_of(organ_)),
      tray_(tray_under(organ_, settings_.shift.y())),
      tip_(scene::sphere_mesh(settings_.tip_radius)),
      stylus_(scene::cylinder_mesh(Vector3::Zero(), {0.0, 0.0, kStylusLength_m}, kStylusRadius_m)),
      mark_(scene::sphere_mesh(kMarkRadius_m, 12, 24)),
      tint_(organ_, {.young = settings_.young_pa, .poisson = settings_.poisson}),
      revealed_(organ_, settings_) {}

void PalpationView::add_nodules(const scene::SceneState& state, std::vector<scene::DrawItem>& items) const {
  const auto& nodules = revealed_.of(state);
  const auto& organ = state.bodies[kOrgan];
  const std::size_t count = std::min(nodules.size(), kMostNodules);
  if (meshes_of_ != state.counters[kNoduleSeed]) {
    for (std::size_t i = 0; i < count; ++i) nodule_meshes_[i] = scene::sphere_mesh(nodules[i].ball.radius);
    meshes_of_ = state.counters[kNoduleSeed];
  }
  const Score score = score_of(nodules, marks_of(state), settings_.rules.within);
  for (std::size_t i = 0; i < count; ++i)
    items.push_back({.mesh = &nodule_meshes_[i],
                     .look = std::isfinite(score.error[i]) ? kNoduleLook : kMissedNoduleLook,
                     .rotation = organ.q(),
                     .position = organ.p() + organ.q() * nodules[i].ball.centre,
                     .sphere_radius = nodules[i].ball.radius});
}

void PalpationView::add_marks(const scene::SceneState& state, std::vector<scene::DrawItem>& items) const {
  const auto& organ = state.bodies[kOrgan];
  const bool shown = is_shown(state);
  const auto& nodules = revealed_.of(state);
  for (const Vector3& mark : marks_of(state)) {
    const bool right = std::any_of(nodules.begin(), nodules.end(), [&](const HiddenNodule& nodule) {
      return (nodule.above - mark).norm() <= settings_.rules.within;
    });
    items.push_back({.mesh = &mark_,
                     .look = !shown  ? kMarkLook
                             : right ? kRightMarkLook
                                     : kFalseMarkLook,
                     .rotation = organ.q(),
                     .position = organ.p() + organ.q() * (mark + kOnTop_m * Vector3::UnitY()),
                     .sphere_radius = kMarkRadius_m});
  }
}

scene::DrawItem PalpationView::organ_item(const scene::SceneState& state) const {
  const auto& organ = state.bodies[kOrgan];
  scene::DrawItem item{
      .mesh = &seen_, .look = kLiverLook, .rotation = organ.q(), .position = organ.p(), .deforms = true};
  if (is_shown(state) || way_ == Way::net) {
    item.mesh = &net_;
    item.look = kNetLook;
    return item;
  }
  const TintPress press{Vector3(state.continuous.point.data()),
                        state.continuous.touching != 0 ? 1e-6 * state.counters[kDepthUm] : 0.0,
                        1e-3 * state.counters[kForceMn], settings_.tip_radius};
  if (way_ == Way::stress) {
    item.look = kStressLook;
    item.tint = tint_.stress(shape_.get(), press);
    most_stress_ = OrganTint::kFullStress * OrganTint::largest(*item.tint);
  } else {
    item.tint = tint_.living(shape_.get(), press);
  }
  return item;
}

std::vector<scene::DrawItem> PalpationView::draw(const scene::SceneState& state) const {
  std::vector<scene::DrawItem> items;
  if (state.body_count <= kTip) return items;
  const bool shown = is_shown(state);
  items.push_back(organ_item(state));
  if (!tray_.triangles.empty())
    items.push_back({.mesh = &tray_,
                     .look = kTrayLook,
                     .rotation = X_world_rest_.rotation,
                     .position = X_world_rest_.translation});
  if (shown) add_nodules(state, items);
  add_marks(state, items);
  const auto& tip = state.bodies[kTip];
  if (tip.visible == 0) return items;
  const bool hard = 1e-3 * state.counters[kForceMn] > settings_.rules.hard_n;
  items.push_back({.mesh = &tip_,
                   .look = hard                             ? kHardTipLook
                           : state.continuous.touching != 0 ? kPressingTipLook
                                                            : kTipLook,
                   .rotation = tip.q(),
                   .position = tip.p(),
                   .sphere_radius = settings_.tip_radius});
  items.push_back({.mesh = &stylus_, .look = kStylusLook, .rotation = tip.q(), .position = tip.p()});
  return items;
}

std::vector<std::string> PalpationView::captions(const scene::SceneState& state) const {
  const auto& c = state.counters;
  const double force = 1e-3 * c[kForceMn], hard = settings_.rules.hard_n;
  std::vector<std::string> lines;
  lines.push_back(fmt::format("force {:.2f} N{}", force, force > hard ? ": too hard" : ""));
  if (way_ == Way::stress && !is_shown(state))
    lines.push_back(fmt::format("yellow: stress of {:.0f} kPa (von Mises); here {:.1f} at most",
                                1e-3 * OrganTint::kFullStress, 1e-3 * most_stress_));
  const auto told = level_told(settings_, state);
  const std::string level = told ? fmt::format("   level {}", *told) : "";
  if (is_shown(state)) {
    const auto nodules = static_cast<std::int32_t>(revealed_.of(state).size());
    lines.push_back(fmt::format("found {} of {}   missed {}   false alarms {}{}", c[kFound], nodules,
                                nodules - c[kFound], c[kFalseAlarms], level));
    if (c[kErrorUm] >= 0)
      lines.push_back(fmt::format("marked {:.1f} mm beside the middle (median)", 1e-3 * c[kErrorUm]));
    lines.emplace_back(settings_.rules.pause_s > 0.0 ? "the next trial begins by itself; Space: at once"
                                                     : "Space: the next trial");
    return lines;
  }
  if (c[kPhase] == static_cast<std::int32_t>(TrialPhase::ready)) {
    lines.push_back(fmt::format("trial {}: find what is hard inside{}", c[kTrial], level));
    lines.emplace_back("touch the organ to begin");
    return lines;
  }
  lines.push_back(fmt::format("{:.0f} of {:.0f} s   marks {}   too hard {}{}", 1e-3 * c[kSearchMs],
                              settings_.rules.seconds, c[kMarks], c[kHardPresses], level));
  if (c[kDwellPermille] > 300)
    lines.push_back(fmt::format("hold still to mark: {} %", c[kDwellPermille] / 10));
  else if (c[kMarks] > 0)
    lines.emplace_back("all found? put the stylus away");
  return lines;
}

}  // namespace palpate::applications::palpation
