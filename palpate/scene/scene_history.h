// The world's states of the last seconds: 8 s at 1 kHz, 4 s at 2 kHz.
//
// Filled by the physics loop, asked by any number of threads (see palpate/time/state_history.h). Between two
// entries bodies go as interpolate() says, never across an impact; beyond the newest as extrapolate() says.
// About 9 MB.
#pragma once

#include "palpate/scene/scene_state.h"
#include "palpate/time/state_history.h"

namespace palpate::scene {

class SceneHistory {
 public:
  // Gravity (m/s^2, World) bends the path next to an impact. A tenth of a second ahead a ball at 5 m/s
  // without forces is wrong by 5 cm of fall: further ahead the answer is too_new.
  explicit SceneHistory(const Vector3& gravity, Duration max_extrapolation = std::chrono::milliseconds(100))
      : history_(max_extrapolation), gravity_(gravity) {}

  bool push(const SceneState& state) noexcept { return history_.push(state); }
  std::uint64_t count() const noexcept { return history_.count(); }

  StateAnswer at(Instant<PhysicsClock> when) const {
    return history_.at(
        when,
        [this](const SceneState& a, const SceneState& b, double s) { return interpolate(a, b, s, gravity_); },
        [](const SceneState& a, Duration ahead) { return extrapolate(a, ahead); });
  }

 private:
  StateHistory<SceneState, 8192> history_;
  Vector3 gravity_;
};

}  // namespace palpate::scene
