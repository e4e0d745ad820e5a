#include "palpate/device/marker_history.h"

#include <algorithm>

namespace palpate::device {

void MarkerHistory::add(const MarkerPose& pose) {
  if (!poses_.empty() && pose.time <= poses_.back().time) return;
  poses_.push_back(pose);
  while (poses_.back().time - poses_.front().time > kept_) poses_.pop_front();
}

std::optional<MarkerPose> MarkerHistory::at(Instant<GraphicsClock> time) const {
  const auto after =
      std::lower_bound(poses_.begin(), poses_.end(), time,
                       [](const MarkerPose& pose, Instant<GraphicsClock> t) { return pose.time < t; });
  if (after == poses_.end()) return std::nullopt;
  if (after->time == time) return *after;
  if (after == poses_.begin()) return std::nullopt;
  const auto before = std::prev(after);
  if (after->time - before->time > longest_gap_) return std::nullopt;
  const double s = to_seconds(time - before->time) / to_seconds(after->time - before->time);
  MarkerPose result;
  result.time = time;
  result.rotation = before->rotation.slerp(s, after->rotation);
  result.translation = (1 - s) * before->translation + s * after->translation;
  // Two independent measurements, weighted.
  result.covariance = (1 - s) * (1 - s) * before->covariance + s * s * after->covariance;
  return result;
}

std::optional<MarkerPose> MarkerHistory::predict(Instant<GraphicsClock> time, Duration span) const {
  if (poses_.empty() || time - poses_.back().time > longest_gap_) return std::nullopt;
  const MarkerPose& newest = poses_.back();
  // A line through (turn, shift) relative to the newest pose, over time relative to it.
  double n = 0.0, st = 0.0, stt = 0.0;
  Vector6 sy = Vector6::Zero(), sty = Vector6::Zero();
  for (auto pose = poses_.rbegin(); pose != poses_.rend() && newest.time - pose->time <= span; ++pose) {
    const double t = to_seconds(pose->time - newest.time);
    Vector6 y;
    y << so3_log(pose->rotation * newest.rotation.conjugate()), pose->translation - newest.translation;
    n += 1.0, st += t, stt += t * t, sy += y, sty += t * y;
  }
  const double spread = n * stt - st * st;
  if (n < 3.0 || spread <= 0.0) return std::nullopt;
  const Vector6 rate = (n * sty - st * sy) / spread, at_newest = (sy - rate * st) / n;
  const double ahead = to_seconds(time - newest.time);
  const Vector6 y = at_newest + ahead * rate;
  MarkerPose result = newest;
  result.time = time;
  result.rotation = (so3_exp(y.head<3>()) * newest.rotation).normalized();
  result.translation = newest.translation + y.tail<3>();
  // Variance of a line's value at `ahead`, each pose as uncertain as the newest.
  result.covariance *= (stt - 2.0 * ahead * st + n * ahead * ahead) / spread;
  return result;
}

}  // namespace palpate::device
