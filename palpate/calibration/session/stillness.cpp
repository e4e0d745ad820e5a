#include "palpate/calibration/session/stillness.h"

#include "palpate/math/so3.h"
#include "palpate/time/instant.h"

namespace palpate::calibration::session {
namespace {

constexpr double kDrift = 0.6;  // from half to half, of what poses may scatter by: 1.2 mm/s by default

// The mean of poses, turns as vectors from one of them.
struct MeanPose {
  Vector3 place = Vector3::Zero(), turn = Vector3::Zero();
};

}  // namespace

void Stillness::add(const device::TrackerSample& sample) {
  if (sample.marker != marker_) return;
  if (!sample.seen) return lose();
  if (!window_.empty() && sample.stamp <= window_.back().stamp) {  // a clock begun anew, or said twice
    if (sample.stamp == window_.back().stamp) return;
    lose();
  }
  window_.push_back(sample);
  while (window_.back().stamp - window_.front().stamp > seconds(settings_.window_s)) {
    window_.pop_front();
    whole_ = true;
  }
}

void Stillness::lose() {
  window_.clear();
  whole_ = false;
}

void Stillness::watch(double now_s, std::span<const device::TrackerSample> samples) {
  for (const auto& sample : samples) {
    if (sample.marker != marker_) continue;
    heard_s_ = now_s;
    add(sample);
  }
  if (now_s > heard_s_ + settings_.silent_s) lose();
}

bool Stillness::still() const {
  if (!whole_ || window_.size() < 2) return false;
  const auto& origin = window_[window_.size() / 2];
  MeanPose halves[2];
  const std::size_t half = window_.size() / 2;
  double place_squares = 0.0, turn_squares = 0.0;
  for (std::size_t i = 0; i < window_.size(); ++i) {
    const Vector3 place = window_[i].translation - origin.translation;
    const Vector3 turn = so3_log(window_[i].rotation * origin.rotation.conjugate());
    const auto n = static_cast<double>(i < half ? half : window_.size() - half);
    halves[i < half ? 0 : 1].place += place / n;
    halves[i < half ? 0 : 1].turn += turn / n;
    place_squares += place.squaredNorm();
    turn_squares += turn.squaredNorm();
  }
  const auto n = static_cast<double>(window_.size());
  const double first = static_cast<double>(half) / n;
  const auto scatter = [&](double squares, const Vector3& a, const Vector3& b) {
    return squares / n - (first * a + (1.0 - first) * b).squaredNorm();
  };
  const auto square = [](double x) { return x * x; };
  return scatter(place_squares, halves[0].place, halves[1].place) <= square(settings_.place) &&
         scatter(turn_squares, halves[0].turn, halves[1].turn) <= square(settings_.turn) &&
         (halves[1].place - halves[0].place).norm() <= kDrift * settings_.place &&
         (halves[1].turn - halves[0].turn).norm() <= kDrift * settings_.turn;
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
