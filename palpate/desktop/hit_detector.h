// Impacts and bounces found in the states of a virtual world, for the ear and for the force bar.
//
// An impact on the hand (SceneState::impact) counts when it has ended: its impulse is the sum of force and
// time. A bounce is a jump of a body's velocity at a place it could have flown to; a body that was put
// elsewhere (a serve) makes no sound, nor does one that was at rest in one of the two states. States in the
// order of their times, gaps allowed: what happened in a gap longer than kGap_s is not told. Pure; one
// thread.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "palpate/scene/scene_state.h"

namespace palpate::desktop {

enum class HitKind {
  hand,  // on what the hand holds
  body,  // two other things
};

struct Hit {
  HitKind kind = HitKind::hand;
  Instant<PhysicsClock> time;  // when it was over
  double impulse = 0.0;        // N s
  double peak = 0.0;           // N; hand only
};

class HitDetector {
 public:
  static constexpr double kGap_s = 0.02;
  static constexpr double kSoftest = 0.15;  // m/s: a slower bounce is not heard

  // Of body 0, 1, ..., kg; 0, or none for a body: it makes no sound.
  explicit HitDetector(std::vector<double> masses) : masses_(std::move(masses)) {}

  // At most one for each state; an impact goes before a bounce.
  std::optional<Hit> look(const scene::SceneState& state);

 private:
  std::vector<double> masses_;
  std::optional<scene::SceneState> last_;
  double impulse_ = 0.0, peak_ = 0.0;  // of the contact that lasts
};

}  // namespace palpate::desktop
