#include "applications/palpation/trainee.h"

#include <algorithm>
#include <cmath>

#include "applications/palpation/palpation.h"

namespace palpate::applications::palpation {
namespace {

constexpr double kHover_m = 0.005,
                 kHighHover_m = 0.025;  // above the surface: between presses, at begin and end
constexpr double kTravelSpeed = 0.25, kCrossSpeed = 0.16;  // m/s, mean
constexpr double kLeastCross_s = 0.09, kDown_s = 0.10, kHold_s = 0.10, kUp_s = 0.07, kThink_s = 0.25;
constexpr double kLeastTravel_s = 0.5;
constexpr double kSlow = 0.012;      // m/s: what is felt when moving faster is not the tissue's own
constexpr double kPressed = 0.5;     // share of the depth wanted from which on a press is felt
constexpr double kPressable = 0.75;  // least upward part of the normal
constexpr double kExponent = 1.5;    // of force over depth: presses of different depth are compared by it
constexpr double kLearn = 0.4, kMostDeeper_m = 0.004;
// After the grid it presses where a nodule is likeliest by then, several places before it thinks again.
constexpr int kRounds = 3;
constexpr std::size_t kOfRound = 3;
constexpr double kApartInRound_m = 0.012;
constexpr int kMostTries = 3;
constexpr double kBeyond = 0.1;       // spacings: so far it searches beyond the area
constexpr double kPatience_s = 1.5;   // beyond the time that marking takes
constexpr double kMarking_s = 0.8;    // of coming to a place
constexpr double kMostApart_s = 0.4;  // pictures, for the hold to last from one to the next
constexpr double kLean = 0.9;         // rad: the stylus leans from the user up to the vertical by that much

double weber_of(const TraineeSettings& settings) { return std::max(1e-6, settings.weber_fraction); }

double highest_of(const scene::TriangleMesh& mesh) {
  double top = 0.0;
  for (const auto& v : mesh.vertices) top = std::max(top, v.y());
  return top;
}

}  // namespace

Trainee::Trainee(const scene::SceneDescription& scene, const scene::Reach& reach,
                 const scene::PlayerSettings& settings)
    : palpation_(palpation_settings(scene)),
      reach_(reach),
      settings_(settings),
      X_world_body_(resting_place(scene)),
      surface_(pressed_mesh(scene)),
      normals_(vertex_normals(surface_)),
      mesh_(surface_),
      top_(highest_of(surface_)),
      weber_(weber_of(palpation_.trainee)),
      observer_({.weber_fraction = weber_, .lapse_rate = 0.0}, settings.seed),
      grid_(places_in_reach(scene)),
      map_(empty_map()),
      hand_(settings.hand, settings.max_acceleration, reach.home()) {
  plan_grid();
  path_ = scene::Quintic({reach_.home(), Vector3::Zero(), Vector3::Zero()},
                         {reach_.home(), Vector3::Zero(), Vector3::Zero()}, kLeastTravel_s);
}

PressMap Trainee::empty_map() const {
  return {grid_, palpation_.trainee.spacing, experiment::noise_of_weber_fraction(weber_),
          PressMap::Trend::quadratic};
}

void Trainee::plan_grid() {
  queue_.clear();
  for (std::size_t i = grid_.size(); i-- > 0;) queue_.push_back(i);
  tries_.assign(grid_.size(), 0);
}

// Whether other nodules are hidden now than those it has searched for: of another trial, or put back by a reset.
bool Trainee::begins_again(const scene::SceneState& state) {
  const bool ready = state.counters[kPhase] == static_cast<std::int32_t>(TrialPhase::ready);
  const bool again = trial_ > 0 && (state.counters[kTrial] != trial_ || (ready && searched_));
  trial_ = state.counters[kTrial];
  searched_ = !ready;
  return again;
}

// How deep its hand must aim is of its arm: that it keeps.
void Trainee::forget() {
  map_ = empty_map();
  plan_grid();
  presses_.clear();
  to_mark_.clear();
  rounds_ = 0;
  marking_ = decided_ = false;
  if (doing_ == Doing::pressing || doing_ == Doing::holding) go(last_, over(here_, kHover_m), kUp_s);
  doing_ = Doing::coming;
}

std::optional<Trainee::Spot> Trainee::spot_at(const PlanPlace& place) const {
  const Vector3 from(place.x(), top_ + 0.01, place.y()), to(place.x(), -0.01, place.y());
  const auto hit = mesh_.ray(from, to);
  if (!hit) return std::nullopt;
  const Vector3 at = from + hit->fraction * (to - from);
  const auto& t = surface_.triangles[hit->triangle];
  Vector3 normal = Vector3::Zero();
  for (const auto corner : t) normal += normals_[corner];
  normal.normalize();
  if (normal.y() < kPressable) return std::nullopt;
  return Spot{at, normal};
}

Vector3 Trainee::over(const Spot& spot, double height) const {
  return (X_world_body_ * Point<Body>{spot.place + (palpation_.tip_radius + height) * spot.normal}).m;
}

bool Trainee::can_press(const PlanPlace& place) const {
  const auto spot = spot_at(place);
  return spot && reach_.contains(over(*spot, kHighHover_m)) &&
         reach_.contains(over(*spot, -palpation_.trainee.press - kMostDeeper_m));
}

// Of the area that nodules lie in.
std::vector<PlanPlace> Trainee::places_in_reach(const scene::SceneDescription&) const {
  const SearchArea area = search_area(surface_);
  const double spacing = palpation_.trainee.spacing;
  const PlanPlace half(area.half_x + kBeyond * spacing, area.half_z + kBeyond * spacing);
  std::vector<PlanPlace> kept;
  for (const auto& place : grid_of({area.centre_x, area.centre_z}, half, spacing))
    if (can_press(place)) kept.push_back(place);
  return kept;
}

void Trainee::show(const scene::SceneState& state, Instant<PhysicsClock> displayed) {
  if (shown_ >= 0.0) apart_ = std::clamp(displayed.seconds() - shown_, 0.0, kMostApart_s);
  shown_ = displayed.seconds();
  waiting_.push_back({state, displayed + seconds(settings_.reaction_s)});
}

// The force at the depth wanted, from the states in which the tip hardly moves.
void Trainee::feel(const scene::SceneState& state, Press& press) const {
  const double depth = 1e-6 * state.counters[kDepthUm], force = Vector3(state.continuous.force.data()).norm();
  if (depth < kPressed * palpation_.trainee.press || !(force > 0.0)) return;
  const double speed = std::max(kSlow, state.bodies[kTip].v().norm());
  if (speed > press.slowest) return;
  if (speed < press.slowest) press.sum = press.depth = 0.0, press.count = 0;
  press.slowest = speed;
  press.sum += std::log(force) - kExponent * std::log(depth / palpation_.trainee.press);
  press.depth += depth;
  ++press.count;
}

void Trainee::learn(const Press& press) {
  if (press.count == 0) {  // it was not felt: the world stood still, or the hand did not get there
    if (tries_[press.place]++ < kMostTries && !decided_) queue_.insert(queue_.begin(), press.place);
    return;
  }
  const double depth = press.depth / press.count;
  deeper_ = std::clamp(deeper_ + kLearn * (palpation_.trainee.press - depth), 0.0, kMostDeeper_m);
  const double felt = palpation_.trainee.senses ? std::exp(press.sum / press.count) : 1.0;
  map_.felt(press.place, observer_.perceived(felt));
}

void Trainee::notice(const scene::SceneState& state) {
  if (state.body_count <= kTip) return;
  if (begins_again(state)) forget();
  marks_ = state.counters[kMarks];
  const double t = state.time.seconds();
  searching_since_ = t - 1e-3 * state.counters[kSearchMs];
  while (!presses_.empty() && presses_.front().to < t) {
    learn(presses_.front());
    presses_.pop_front();
  }
  if (!presses_.empty() && presses_.front().from <= t) feel(state, presses_.front());
}

void Trainee::go(double now, const Vector3& to, double duration) {
  const scene::HandState from{path_.at(now - begin_).position, Vector3::Zero(), Vector3::Zero()};
  path_ = scene::Quintic(from, {to, Vector3::Zero(), Vector3::Zero()}, duration);
  begin_ = now;
}

void Trainee::approach(double now, const PlanPlace& place) {
  if (const auto spot = spot_at(place)) here_ = *spot;
  const Vector3 to = over(here_, kHover_m);
  doing_ = Doing::crossing;
  go(now, to, std::max(kLeastCross_s, (to - path_.at(now - begin_).position).norm() / kCrossSpeed));
}

// Whether there is just time enough left to mark what it believes.
bool Trainee::time_is_short(double now) const {
  const double marking =
      kPatience_s + (kMarking_s + palpation_.rules.dwell_s) * static_cast<double>(palpation_.nodules.most);
  return now + marking > searching_since_ + palpation_.rules.seconds;
}

// The likeliest places that can be pressed.
void Trainee::look_closer() {
  for (const PlanPlace& place : map_.likeliest(kOfRound, kApartInRound_m)) {
    if (!can_press(place)) continue;
    queue_.push_back(map_.add_place(place));
    tries_.push_back(0);
  }
}

void Trainee::after_thinking(double now) {
  if (rounds_ < kRounds && !time_is_short(now)) {
    ++rounds_;
    look_closer();
  } else if (!decided_) {
    decided_ = marking_ = true;
    constexpr double kApart_m = 0.018;
    const auto& nodules = palpation_.nodules;
    to_mark_ = map_.believed(static_cast<std::size_t>(nodules.fewest), static_cast<std::size_t>(nodules.most),
                             kApart_m);
    std::reverse(to_mark_.begin(), to_mark_.end());
  }
  if (!queue_.empty()) {
    approach(now, map_.places()[queue_.back()]);
  } else if (!to_mark_.empty()) {
    marks_before_ = marks_;
    approach(now, to_mark_.back());
  } else {
    doing_ = Doing::leaving;
    const Vector3 up = X_world_body_.rotation * Vector3(0.0, top_ + Trial::kAway_m + kHighHover_m, 0.0);
    const Vector3 here = path_.at(now - begin_).position;
    const double rise = up.dot(X_world_body_.rotation * Vector3::UnitY()) -
                        (here - X_world_body_.translation).dot(X_world_body_.rotation * Vector3::UnitY());
    go(now, here + X_world_body_.rotation * Vector3(0.0, std::max(0.0, rise), 0.0), kLeastTravel_s);
  }
}

// Until a picture has shown it.
void Trainee::hold(double now) {
  const double held = std::max(kHold_s, apart_);
  go(now, path_.at(now - begin_).position, marking_ ? palpation_.rules.dwell_s + held : held);
  if (!marking_) presses_.push_back({.place = queue_.back(), .from = now, .to = now + held});
}

void Trainee::next(double now) {
  switch (doing_) {
    case Doing::coming: {
      if (queue_.empty()) {  // nothing is in reach
        doing_ = Doing::resting;
        return;
      }
      const auto spot = spot_at(map_.places()[queue_.back()]);
      if (!spot) return;
      here_ = *spot;
      const Vector3 to = over(here_, kHover_m);
      doing_ = Doing::crossing;
      go(now, to, std::max(kLeastTravel_s, (to - path_.at(now - begin_).position).norm() / kTravelSpeed));
      return;
    }
    case Doing::crossing:
      doing_ = Doing::pressing;
      go(now, over(here_, -palpation_.trainee.press - deeper_), kDown_s);
      return;
    case Doing::pressing:
      doing_ = Doing::holding;
      hold(now);
      return;
    case Doing::holding:
      if (marking_ && marks_ <= marks_before_ && now - begin_ < palpation_.rules.dwell_s + kPatience_s)
        return;
      doing_ = Doing::rising;
      go(now, over(here_, kHover_m), kUp_s);
      return;
    case Doing::rising:
      if (marking_)
        to_mark_.pop_back();
      else
        queue_.pop_back();
      if (!marking_ && time_is_short(now)) queue_.clear();
      if (!queue_.empty()) return approach(now, map_.places()[queue_.back()]);
      doing_ = Doing::thinking;
      go(now, path_.at(now - begin_).position, marking_ ? kUp_s : kThink_s);
      return;
    case Doing::thinking:
      return after_thinking(now);
    case Doing::leaving:
    case Doing::resting:
      doing_ = Doing::resting;
      return;
  }
}

void Trainee::take_over(const device::HandTarget& at, Instant<PhysicsClock> now) {
  waiting_.clear();
  presses_.clear();
  hand_ = scene::HandTrajectory(settings_.hand, settings_.max_acceleration, at.tip.m, at.velocity);
  const double way = (reach_.home() - at.tip.m).norm();
  path_ = scene::Quintic({at.tip.m, at.velocity, Vector3::Zero()},
                         {reach_.home(), Vector3::Zero(), Vector3::Zero()},
                         std::max(kLeastTravel_s, way / kTravelSpeed));
  begin_ = now.seconds();
  doing_ = queue_.empty() ? Doing::thinking : Doing::coming;
}

device::HandTarget Trainee::act(Instant<PhysicsClock> instant) {
  const double now = instant.seconds();
  if (last_ < 0.0) begin_ = now;
  last_ = now;
  while (!waiting_.empty() && waiting_.front().ready <= instant) {
    notice(waiting_.front().state);
    waiting_.pop_front();
  }
  if (now - begin_ >= path_.duration()) next(now);
  const scene::HandState& target = hand_.follow(
      now, [this](double t) { return path_.at(t - begin_); },
      [this](double t) { return path_.jerk(t - begin_); });
  return {{target.position},
          target.velocity,
          X_world_body_.rotation * Quaternion(Eigen::AngleAxisd(-kLean, Vector3::UnitX()))};
}

}  // namespace palpate::applications::palpation
