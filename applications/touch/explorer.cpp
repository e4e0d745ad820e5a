#include "applications/touch/explorer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "applications/touch/organ.h"
#include "palpate/math/random_vector.h"

namespace palpate::applications::touch {
namespace {

constexpr double kHover_m = 0.015;       // above the highest place, between two rounds
constexpr double kWanted_N = 0.8;        // what it likes to press with: below what such an arm holds for long
constexpr double kFirstPress_m = 0.004;  // below the surface, before it has felt anything
constexpr double kDeepest_m = 0.010;
constexpr double kLearn = 0.010;  // m/s deeper per N that is missing: slow beside the lateness of seeing
constexpr double kDownSpeed = 0.04, kTravelSpeed = 0.25;          // m/s, mean
constexpr std::array<double, 3> kStrokeSpeeds{0.02, 0.06, 0.12};  // m/s, mean, one after the other
constexpr double kHold_s = 0.4, kLift_s = 0.4, kLeastTravel_s = 0.5;
constexpr double kShare = 0.7;            // of the box's half sides: further out it slopes too much
constexpr double kLevel = 0.7;            // least upward part of the normal
constexpr double kShortest_m = 0.015;     // stroke
constexpr int kTries = 8, kSamples = 12;  // per call, so that no picture waits
constexpr double kAgain_s = 0.05;
constexpr double kBeneath_m = 0.004;  // so far the tip itself goes down
constexpr double kLean = 0.9;         // rad: the stylus leans from the user up to the vertical by that much

double eased(double s) {  // least jerk from 0 to 1
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

}  // namespace

Explorer::Explorer(const scene::SceneDescription& scene, const scene::Reach& reach,
                   const scene::PlayerSettings& settings)
    : reach_(reach),
      settings_(settings),
      surface_(touched_mesh(scene)),
      mesh_(surface_),
      random_(settings.seed, "touch/explorer"),
      press_(kFirstPress_m),
      hand_(settings.hand, settings.max_acceleration, reach.home()) {
  for (const auto& v : surface_.vertices) {
    half_ = half_.cwiseMax(v.cwiseAbs());
    top_ = std::max(top_, v.y());
  }
  const scene::HandState home{reach_.home(), Vector3::Zero(), Vector3::Zero()};
  travel_ = scene::Quintic(home, home, 1.0);
}

void Explorer::show(const scene::SceneState& state, Instant<PhysicsClock> displayed) {
  waiting_.push_back({state, displayed + seconds(settings_.reaction_s)});
}

void Explorer::notice(const scene::SceneState& state) {
  if (state.body_count <= kProxy) return;
  const auto& organ = state.bodies[kOrgan];
  const Vector3 noise =
      normal3(random_, settings_.perception_sd).reverse();  // as it was first drawn: z before x
  // What stands still is known better the longer one looks.
  constexpr double kNew = 0.1;
  const Vector3 seen = organ.p() + noise;
  X_world_organ_.translation =
      known_ ? Vector3((1.0 - kNew) * X_world_organ_.translation + kNew * seen) : seen;
  X_world_organ_.rotation = organ.q();
  known_ = true;
  felt_ = 1e-3 * state.counters[kForceMn];
}

// Where the tip's centre would rest over (x, z): the sphere let down on the surface.
std::optional<double> Explorer::resting_height(double x, double z) const {
  const double radius = Settings{}.tip_radius, high = top_ + 2.0 * radius;
  const auto hit = mesh_.sweep({x, high, z}, {x, -half_.y(), z}, radius);
  if (!hit) return std::nullopt;
  return high - hit->fraction * (high + half_.y());
}

// Two places on the upper side with nothing steep between them, within reach, pressed on and hovered over.
bool Explorer::choose() {
  for (int i = 0; i < kTries; ++i) {
    const auto anywhere = [&] {
      const double z = random_.uniform(-kShare, kShare), x = random_.uniform(-kShare, kShare);
      return Vector3(x * half_.x(), 0.0, z * half_.z());
    };
    const Vector3 a = anywhere(), b = anywhere();
    if ((b - a).norm() < std::min(kShortest_m, half_.head<1>().norm())) continue;
    bool good = true;
    for (int k = 0; k <= kSamples && good; ++k) {
      const Vector3 p = a + (b - a) * k / kSamples;
      good = reach_.contains((X_world_organ_ * Point<Organ>{{p.x(), top_ + kHover_m, p.z()}}).m);
      if (!good) break;
      const auto hit =
          mesh_.sweep({p.x(), top_ + 0.01, p.z()}, {p.x(), -half_.y(), p.z()}, Settings{}.tip_radius);
      good = hit && hit->normal.y() > kLevel;
      if (!good) break;
      const double height = *resting_height(p.x(), p.z()) - kBeneath_m;
      good = reach_.contains((X_world_organ_ * Point<Organ>{{p.x(), height, p.z()}}).m);
    }
    if (!good) continue;
    const double aim_z = random_.normal(settings_.aim_sd), aim_x = random_.normal(settings_.aim_sd);
    const Vector3 aim(aim_x, 0.0, aim_z);
    here_ = resting_height(a.x() + aim.x(), a.z() + aim.z()) ? Vector3(a + aim) : a;
    there_ = b;
    return true;
  }
  return false;
}

Vector3 Explorer::place(double t) const {
  const double s = eased((t - move_.begin) / move_.duration);
  const Vector3 p = move_.from + s * (move_.to - move_.from);
  const double rest = resting_height(p.x(), p.z()).value_or(-half_.y());
  // Above the top it goes by height, at the surface by depth.
  const double y = p.y() > 0.0 ? std::max(rest, rest + p.y() * (top_ + kHover_m - rest)) : rest + p.y();
  return (X_world_organ_ * Point<Organ>{{p.x(), y, p.z()}}).m;
}

bool Explorer::on_surface() const { return doing_ != Doing::waiting && doing_ != Doing::travelling; }

scene::HandState Explorer::planned(double t) const {
  if (!on_surface()) {
    return travel_.at(t - travel_begin_);
  }
  constexpr double kStep = 0.004;
  const Vector3 before = place(t - kStep), now = place(t), after = place(t + kStep);
  return {now, (after - before) / (2.0 * kStep), (after - 2.0 * now + before) / (kStep * kStep)};
}

// From where it is (in x, height, z) to `to`.
void Explorer::move(double now, const Vector3& to, double duration) {
  move_ = {now, std::max(duration, 0.1), move_.to, to};
}

void Explorer::next(double now) {
  const Vector3 pressed(0.0, -press_, 0.0), up(0.0, 1.0, 0.0);
  const double length = (there_ - here_).norm();
  const auto speed = [&] {
    return kStrokeSpeeds[static_cast<std::size_t>(rounds_++) % kStrokeSpeeds.size()];
  };
  switch (doing_) {
    case Doing::waiting:
    case Doing::lifting: {
      const scene::HandState from{planned(now).position, Vector3::Zero(), Vector3::Zero()};
      if (!known_ || now < try_at_) return;
      try_at_ = now + kAgain_s;
      if (!choose()) return;
      move_.to = here_ + up;
      const scene::HandState to{(X_world_organ_ * Point<Organ>{{here_.x(), top_ + kHover_m, here_.z()}}).m,
                                Vector3::Zero(), Vector3::Zero()};
      travel_ = scene::Quintic(from, to,
                               std::max(kLeastTravel_s, (to.position - from.position).norm() / kTravelSpeed));
      travel_begin_ = now;
      doing_ = Doing::travelling;
      break;
    }
    case Doing::travelling:
      doing_ = Doing::coming_down;
      move(now, here_ + pressed,
           (top_ + kHover_m - resting_height(here_.x(), here_.z()).value_or(0.0)) / kDownSpeed);
      break;
    case Doing::coming_down:
      doing_ = Doing::holding;
      move(now, here_ + pressed, kHold_s);
      break;
    case Doing::holding:
      doing_ = Doing::stroking;
      move(now, there_ + pressed, length / speed());
      break;
    case Doing::stroking:
      doing_ = Doing::stroking_back;
      move(now, here_ + pressed, length / speed());
      break;
    case Doing::stroking_back:
      doing_ = Doing::lifting;
      move(now, here_ + up, kLift_s);
      break;
  }
}

void Explorer::take_over(const device::HandTarget& at, Instant<PhysicsClock> now) {
  waiting_.clear();
  felt_ = 0.0;
  hand_ = scene::HandTrajectory(settings_.hand, settings_.max_acceleration, at.tip.m, at.velocity);
  // From wherever it is: home first, above everything, then the next round.
  const scene::HandState home{reach_.home(), Vector3::Zero(), Vector3::Zero()};
  const double way = (home.position - at.tip.m).norm();
  travel_ = scene::Quintic({at.tip.m, at.velocity, Vector3::Zero()}, home,
                           std::max(kLeastTravel_s, way / kTravelSpeed));
  travel_begin_ = now.seconds();
  try_at_ = now.seconds() + travel_.duration();
  doing_ = Doing::waiting;
}

device::HandTarget Explorer::act(Instant<PhysicsClock> instant) {
  const double now = instant.seconds();
  const double h = last_ > 0.0 ? std::clamp(now - last_, 0.0, 0.1) : 0.0;
  last_ = now;
  while (!waiting_.empty() && waiting_.front().ready <= instant) {
    notice(waiting_.front().state);
    waiting_.pop_front();
  }
  if (doing_ == Doing::holding || doing_ == Doing::stroking || doing_ == Doing::stroking_back) {
    const double deeper = std::clamp(press_ + h * kLearn * (kWanted_N - felt_), 0.0, kDeepest_m) - press_;
    press_ += deeper;
    move_.from.y() -= deeper;
    move_.to.y() -= deeper;
  }
  const bool done = doing_ == Doing::waiting || (on_surface() ? now >= move_.begin + move_.duration
                                                              : now >= travel_begin_ + travel_.duration());
  if (done) next(now);
  const scene::HandState& target = hand_.follow(
      now, [this](double t) { return planned(t); }, [](double) { return Vector3(Vector3::Zero()); });
  return {{target.position},
          target.velocity,
          X_world_organ_.rotation * Quaternion(Eigen::AngleAxisd(-kLean, Vector3::UnitX()))};
}

}  // namespace palpate::applications::touch
