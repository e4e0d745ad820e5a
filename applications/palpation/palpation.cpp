#include "applications/palpation/palpation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace palpate::applications::palpation {
namespace {

constexpr double kShapeEvery_s = 0.004;  // twice as often as shapes are kept

std::unique_ptr<PreparedTrial> first_trial(const TrialPlan& plan, std::optional<int> level) {
  if (const auto fit = levels_fit(plan); !fit) throw std::runtime_error(fit.error().message);
  auto trial = prepare_trial(plan, 1, level);
  if (!trial) throw std::runtime_error(trial.error().message);
  return std::move(*trial);
}

TrialPlan plan_of(const scene::SceneDescription& scene, const scene::RunSettings& run,
                  const std::filesystem::path& cache) {
  return {palpation_settings(scene), pressed_mesh(scene), resting_place(scene), run.seed, cache};
}

double top_of(const scene::TriangleMesh& mesh) {
  double top = 0.0;
  for (const auto& v : mesh.vertices) top = std::max(top, v.y());
  return top;
}

std::int32_t in_thousandths(double value) {
  return static_cast<std::int32_t>(std::lround(std::clamp(1e3 * value, -1e9, 1e9)));
}

void put(const Vector3& v, float* out) {
  for (int k = 0; k < 3; ++k) out[k] = static_cast<float>(v[k]);
}

}  // namespace

std::optional<int> level_told(const PalpationSettings& settings, const scene::SceneState& state) {
  const std::int32_t told = state.counters[kNoduleSeed];
  if (settings.difficulty != Difficulty::staircase || told == 0) return std::nullopt;
  return told > 0 ? level_in_seed(told) : std::clamp(-1 - told, 0, kHardestLevel);
}

PalpationApplication::PalpationApplication(const scene::SceneDescription& scene,
                                           const scene::RunSettings& run, const std::filesystem::path& cache)
    : settings_(palpation_settings(scene)),
      carried_offset_(scene.carried_offset),
      ahead_(run.pause_s.has_value()),
      X_world_organ_(resting_place(scene)),
      surface_(pressed_mesh(scene)),
      training_(settings_, run.keeps_files),
      prepared_(first_trial(plan_of(scene, run, cache), training_.level())),
      preparer_(plan_of(scene, run, cache), training_),
      law_(prepared_->law),
      trial_(settings_.rules, top_of(surface_)),
      vertices_(surface_.vertices),
      normals_(surface_.vertices.size()),
      shape_(surface_.vertices.size() * scene::Shape::kFloatsPerVertex) {
  if (surface_.vertices.size() > scene::Shape::kMaxVertices)
    throw std::invalid_argument("palpation: the mesh has more than 40000 vertices; simplify it");
  trial_.prepare(prepared_->nodules);
  marks_seen_.fill(Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
  dent(1.0);
}

void PalpationApplication::reset() {
  ++resets_;
  trial_.prepare(prepared_->nodules);
}

// Once of each trial: who searches again after a reset has seen where its nodules are.
void PalpationApplication::tell_of_search() {
  if (trial_.phase() != TrialPhase::shown || told_ == number_) return;
  told_ = number_;
  const Score& score = trial_.score();
  FinishedSearch search;
  search.trial = number_;
  if (settings_.difficulty == Difficulty::staircase) search.level = level_in_seed(prepared_->seed);
  search.nodules = score.nodules;
  search.found = score.found;
  search.false_alarms = score.false_alarms;
  search.error = score.median_error();
  search.seconds = trial_.searched_s();
  search.path = trial_.path();
  search.hard_presses = trial_.hard_presses();
  search.peak_force = touch_.resets == resets_ ? touch_.peak_n : 0.0;
  preparer_.tell(search);
}

void PalpationApplication::next_trial() {
  tell_of_search();
  // How hard the next one is, a staircase knows when this one is over, and not before.
  const TrialPhase from =
      settings_.difficulty == Difficulty::staircase ? TrialPhase::shown : TrialPhase::searching;
  if (trial_.next_wanted() || (ahead_ && trial_.phase() == from)) preparer_.want(number_ + 1);
  if (!trial_.next_wanted() || !preparer_.take(prepared_)) return;
  ++number_;
  ++resets_;
  law_.change_to(prepared_->law);
  touch_ = {};
  trial_.prepare(prepared_->nodules);
}

void PalpationApplication::follow_law(Instant<PhysicsClock> now, double dt) {
  prepared_->law.move_body(
      {.time = now, .X_world_body = X_world_organ_, .paused = paused(), .resets = resets_});
  touch_ = prepared_->law.newest();
  const auto& contact = touch_.contact;
  TipOnOrgan tip;
  tip.seen = touch_.tip.allFinite();
  tip.tip = (X_world_organ_.inverse() * Point<World>{touch_.tip}).m;
  tip.depth = touch_.engaged ? contact.depth : 0.0;
  tip.force = touch_.force.norm();
  tip.foot = tip.tip - (settings_.tip_radius - contact.depth) * contact.normal;
  if (!paused()) trial_.step(dt, tip);
}

// The surface as it is pressed now, in World.
void PalpationApplication::dent(double dt) {
  since_shape_ += dt;
  if (since_shape_ < kShapeEvery_s) return;
  since_shape_ = 0.0;
  const bool pressed = touch_.engaged && touch_.contact.depth > 0.0;
  if (!pressed && !dented_ && dt < 1.0) return;
  dented_ = pressed;
  const auto X_organ_world = X_world_organ_.inverse();
  prepared_->organ.dent.press((X_organ_world * Point<World>{touch_.tip}).m,
                              pressed ? touch_.contact.depth : 0.0,
                              X_organ_world.rotation * touch_.static_force, vertices_);
  std::fill(normals_.begin(), normals_.end(), Vector3::Zero());
  for (const auto& t : surface_.triangles) {
    const Vector3& a = vertices_[t[0]];
    const Vector3 area = (vertices_[t[1]] - a).cross(vertices_[t[2]] - a);
    for (const auto corner : t) normals_[corner] += area;
  }
  const Matrix3 R = X_world_organ_.rotation.toRotationMatrix();
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    put(R * vertices_[i] + X_world_organ_.translation, &shape_[6 * i]);
    put(R * normals_[i].normalized(), &shape_[6 * i + 3]);
  }
}

// On the surface as it is dented now.
void PalpationApplication::show_marks(scene::SceneState& state) {
  const auto marks = trial_.marks();
  for (std::size_t i = 0; i < kMostMarks; ++i) {
    auto& body = state.bodies[static_cast<std::size_t>(kFirstMark) + i];
    const bool there = i < marks.size();
    if (!there) marks_seen_[i].setConstant(std::numeric_limits<double>::quiet_NaN());
    if (there && !(marks_seen_[i] == marks[i])) {
      marks_seen_[i] = marks[i];
      ++mark_jumps_;
      double nearest = std::numeric_limits<double>::infinity();
      for (std::size_t v = 0; v < surface_.vertices.size(); ++v)
        if (const double d = (surface_.vertices[v] - marks[i]).squaredNorm(); d < nearest)
          nearest = d, mark_vertices_[i] = v;
    }
    body = {};
    body.visible = there ? 1 : 0;
    body.jumps = mark_jumps_;
    if (!there) continue;
    const std::size_t v = mark_vertices_[i];
    const bool shown = trial_.phase() == TrialPhase::shown;
    const Vector3 at = shown ? marks[i] : Vector3(marks[i] + vertices_[v] - surface_.vertices[v]);
    body.set_p((X_world_organ_ * Point<Body>{at}).m);
    body.set_q(X_world_organ_.rotation);
  }
}

void PalpationApplication::show(const scene::TipState& tip, scene::SceneState& state) {
  state.body_count = kFirstMark + static_cast<int>(kMostMarks);
  auto& organ = state.bodies[kOrgan];
  organ.set_p(X_world_organ_.translation);
  organ.set_q(X_world_organ_.rotation);
  auto& stylus = state.bodies[kStylus];
  auto& end = state.bodies[kTip];
  const Vector3& place = tip.X_world_tip.translation;
  const bool seen = place.allFinite() && tip.velocity.allFinite();
  stylus.visible = end.visible = seen ? 1 : 0;
  if (seen) {
    const Vector3 lever = tip.X_world_tip.rotation * carried_offset_;
    stylus.set_p(place + lever);
    stylus.set_q(tip.X_world_tip.rotation);
    stylus.set_v(tip.velocity + tip.angular_velocity.cross(lever));
    stylus.set_w(tip.angular_velocity);
    end.set_p(place);
    end.set_q(tip.X_world_tip.rotation);
    end.set_v(tip.velocity);
    end.set_w(tip.angular_velocity);
  }
  const Vector3& force = touch_.force;
  const bool touching = touch_.engaged && touch_.contact.depth > 0.0;
  state.continuous.force = {force.x(), force.y(), force.z()};
  state.continuous.touching = touching ? 1 : 0;
  if (touching) {
    const Vector3 point =
        touch_.tip - X_world_organ_.rotation * (settings_.tip_radius * touch_.contact.normal);
    state.continuous.point = {point.x(), point.y(), point.z()};
  }
}

// Counts of the law that have not followed the newest reset yet are 0.
void PalpationApplication::count(scene::SceneState& state) const {
  auto& c = state.counters;
  const bool follows = touch_.resets == resets_, shown = trial_.phase() == TrialPhase::shown;
  const Score& score = trial_.score();
  c[kPhase] = static_cast<std::int32_t>(trial_.phase());
  c[kTrial] = number_;
  c[kForceMn] = in_thousandths(touch_.force.norm());
  c[kPeakForceMn] = follows ? in_thousandths(touch_.peak_n) : 0;
  c[kDepthUm] = touch_.engaged ? in_thousandths(1e3 * touch_.contact.depth) : 0;
  c[kTouches] = follows ? touch_.touches : 0;
  c[kHardPresses] = trial_.hard_presses();
  c[kSearchMs] = in_thousandths(trial_.searched_s());
  c[kPathMm] = in_thousandths(trial_.path());
  c[kMarks] = static_cast<std::int32_t>(trial_.marks().size());
  c[kDwellPermille] = in_thousandths(trial_.dwelt());
  const bool by_level = settings_.difficulty == Difficulty::staircase;
  c[kNoduleSeed] = shown ? prepared_->seed : by_level ? -1 - level_in_seed(prepared_->seed) : 0;
  c[kFound] = shown ? score.found : 0;
  c[kFalseAlarms] = shown ? score.false_alarms : 0;
  c[kErrorUm] = shown && score.found > 0 ? in_thousandths(1e3 * score.median_error()) : -1;
  c[kCreatedNj] = follows ? in_thousandths(1e6 * touch_.created_j) : 0;
}

void PalpationApplication::step(Instant<PhysicsClock> now, Duration dt, const scene::TipState& tip,
                                scene::SceneState& state) {
  const double h = to_seconds(dt);
  follow_law(now, h);
  next_trial();
  if (!paused()) dent(h);
  show(tip, state);
  show_marks(state);
  count(state);
}

}  // namespace palpate::applications::palpation
