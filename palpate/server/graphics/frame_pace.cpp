#include "palpate/server/graphics/frame_pace.h"

#include <algorithm>

namespace palpate::server::graphics {

Instant<GraphicsClock> FramePace::due(Instant<GraphicsClock> image_time, Instant<GraphicsClock> ready) {
  const auto due = age_ ? std::clamp(image_time + *age_, ready, ready + kLongestHold) : ready;
  ages_[pictures_++ % kJudged] = ready - image_time;
  if (pictures_ >= kFewest) find_age();
  return due;
}

void FramePace::find_age() {
  auto ages = ages_;
  const auto count = static_cast<std::ptrdiff_t>(std::min(pictures_, kJudged));
  const auto quantile = [&](double share) {
    const auto at = ages.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(count - 1));
    std::nth_element(ages.begin(), at, ages.begin() + count);
    return *at;
  };
  const Duration median = quantile(0.5);
  age_ = std::min(quantile(kReady), median + kBeyondMedian);
}

}  // namespace palpate::server::graphics
