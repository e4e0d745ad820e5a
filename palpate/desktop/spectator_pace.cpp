#include "palpate/desktop/spectator_pace.h"

#include <algorithm>

namespace palpate::desktop {

bool SpectatorPace::due(Instant<GraphicsClock> begun, Instant<GraphicsClock> now) {
  if (before_) {
    // A gap in which one was drawn for onlookers may be longer for that.
    const Duration gap = begun - *before_;
    const bool undisturbed = !last_ || *last_ < *before_;
    if (undisturbed || gap < beat_) beat_ = beat_ == Duration{0} ? gap : beat_ + (gap - beat_) / 8;
  }
  before_ = begun;
  if (!last_) return true;
  const Duration since = now - *last_;
  if (since < kShortest) return false;
  const Duration spare = begun + beat_ - now;
  return spare >= cost_ || since >= std::max(kOverdue, kShare * cost_);
}

void SpectatorPace::drew(Instant<GraphicsClock> begun, Duration took) {
  last_ = begun;
  cost_ = std::max(took, cost_ + (took - cost_) / 2);
}

}  // namespace palpate::desktop
