#include "palpate/graphics_server/marker_history.h"

#include <algorithm>

namespace palpate {

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

}  // namespace palpate
