#include "palpate/graphics_server/stereo_pair.h"

#include <utility>

namespace palpate {

void StereoPair::left(Timed image) {
  if (left_) ++unpaired_;
  left_ = std::move(image);
}

void StereoPair::right(Timed image) {
  // A left image that did not wait would have had its right one.
  if (alone_time_ && image.time >= *alone_time_ - kSameMoment && image.time <= *alone_time_ + kSameMoment)
    fitted_ = image.at;
  right_.push_back(std::move(image));
  if (right_.size() > kMostWaiting) right_.pop_front();
}

std::optional<StereoPair::Images> StereoPair::take(Instant<GraphicsClock> now) {
  if (!fitted_) fitted_ = now;
  lost_ = now - *fitted_ > kPatience;
  if (!left_) return std::nullopt;
  while (!right_.empty() && right_.front().time < left_->time - kSameMoment) right_.pop_front();
  if (!right_.empty() && right_.front().time <= left_->time + kSameMoment) {
    Images both{std::move(*left_), std::move(right_.front().image)};
    right_.pop_front();
    left_.reset();
    fitted_ = now;
    lost_ = false;
    return both;
  }
  if (lost_) {
    alone_time_ = left_->time;
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

}  // namespace palpate
