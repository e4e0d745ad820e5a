#include "palpate/server/graphics/stereo_pair.h"

#include <utility>

namespace palpate::server::graphics {

void StereoPair::left(Timed image) {
  if (left_) ++unpaired_;
  ++unfitted_;
  left_ = std::move(image);
}

void StereoPair::right(Timed image) {
  // A left image that did not wait would have had its right one.
  if (alone_ && image.moment >= *alone_ - kSameMoment && image.moment <= *alone_ + kSameMoment)
    fitted_ = image.at, unfitted_ = 0;
  right_.push_back(std::move(image));
  if (right_.size() > kMostWaiting) right_.pop_front();
}

std::optional<StereoPair::Images> StereoPair::take(Instant<GraphicsClock> now) {
  if (!fitted_) fitted_ = now;
  lost_ = now - *fitted_ > kPatience && unfitted_ >= kMostUnfitted;
  if (!left_) return std::nullopt;
  while (!right_.empty() && right_.front().moment < left_->moment - kSameMoment) right_.pop_front();
  if (!right_.empty() && right_.front().moment <= left_->moment + kSameMoment) {
    Images both{std::move(*left_), std::move(right_.front().image)};
    right_.pop_front();
    left_.reset();
    fitted_ = now, unfitted_ = 0;
    lost_ = false;
    return both;
  }
  if (lost_) {
    alone_ = left_->moment;
    Images alone{std::move(*left_), std::nullopt};
    left_.reset();
    return alone;
  }
  if (!right_.empty()) {  // of a later moment: this one's was lost
    left_.reset();
    ++unpaired_;
  }
  return std::nullopt;
}

}  // namespace palpate::server::graphics
