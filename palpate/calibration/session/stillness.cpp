#include "palpate/calibration/session/stillness.h"

#include "palpate/time/instant.h"

namespace palpate::calibration::session {

void Stillness::add(const device::TrackerSample& sample) {
  if (sample.marker != marker_) return;
  if (!sample.seen) {
    window_.clear();
    whole_ = false;
    return;
  }
  if (!window_.empty() && sample.stamp <= window_.back().stamp) {  // a clock begun anew, or said twice
    if (sample.stamp == window_.back().stamp) return;
    window_.clear();
    whole_ = false;
  }
  window_.push_back(sample);
  while (window_.back().stamp - window_.front().stamp > seconds(settings_.window_s)) {
    window_.pop_front();
    whole_ = true;
  }
}

bool Stillness::still() const {
  if (!whole_) return false;
  Vector3 mean = Vector3::Zero();
  for (const auto& sample : window_) mean += sample.translation / static_cast<double>(window_.size());
  const Quaternion& middle = window_[window_.size() / 2].rotation;
  for (const auto& sample : window_)
    if ((sample.translation - mean).norm() > settings_.place ||
        sample.rotation.angularDistance(middle) > settings_.turn)
      return false;
  return true;
}

bool Stillness::moved() const {
  if (!taken_ || window_.empty()) return !taken_;
  const auto& now = window_.back();
  return (now.translation - taken_->translation).norm() > settings_.moved ||
         now.rotation.angularDistance(taken_->rotation) > settings_.turned;
}

void Stillness::take() { taken_ = newest(); }

std::optional<device::TrackerSample> Stillness::newest() const {
  return window_.empty() ? std::nullopt : std::optional(window_.back());
}

}  // namespace palpate::calibration::session
