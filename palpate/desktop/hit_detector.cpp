#include "palpate/desktop/hit_detector.h"

#include <algorithm>

namespace palpate::desktop {
namespace {

// Farther from where a body would have flown than its speeds explain, it was put there.
constexpr double kPut_m = 0.01;

double size_of(const std::array<double, 3>& v) { return Vector3(v.data()).norm(); }

}  // namespace

std::optional<Hit> HitDetector::look(const scene::SceneState& state) {
  if (last_ && state.time <= last_->time) return std::nullopt;
  std::optional<Hit> found;
  const double h = last_ ? to_seconds(state.time - last_->time) : 0.0;
  const bool follows = last_ && h <= kGap_s;
  const bool touched = follows && last_->impact.share > 0.0, touches = state.impact.share > 0.0;
  if (!touched) impulse_ = peak_ = 0.0;
  if (touches) {
    // The contact's first step has lasted a share of the step only; half is right on average.
    impulse_ += 0.5 * h * (size_of(state.impact.force) + (touched ? size_of(last_->impact.force) : 0.0));
    peak_ = std::max(peak_, size_of(state.impact.force));
  } else if (touched) {
    impulse_ += 0.5 * h * size_of(last_->impact.force);
    found = Hit{HitKind::hand, state.time, impulse_, peak_};
  }
  if (follows && !touched && !touches) {
    double largest = kSoftest;
    const int both = std::min(std::clamp(last_->body_count, 0, scene::SceneState::kBodies),
                              std::clamp(state.body_count, 0, scene::SceneState::kBodies));
    const std::size_t bodies = std::min(static_cast<std::size_t>(both), masses_.size());
    for (std::size_t i = 0; i < bodies; ++i) {
      const scene::BodyState &a = last_->bodies[i], &b = state.bodies[i];
      if (masses_[i] <= 0.0 || a.jumps == b.jumps || a.visible == 0 || b.visible == 0) continue;
      if (a.v().isZero() || b.v().isZero()) continue;
      const double reach = h * std::max(a.v().norm(), b.v().norm()) + kPut_m;
      const double change = (b.v() - a.v()).norm();
      if ((b.p() - a.p()).norm() > reach || change <= largest) continue;
      largest = change;
      found = Hit{HitKind::body, state.time, masses_[i] * change, 0.0};
    }
  }
  last_ = state;
  return found;
}

}  // namespace palpate::desktop
