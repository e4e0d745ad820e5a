#include "palpate/calibration/session/holds.h"

#include <algorithm>

#include "palpate/math/so3.h"

namespace palpate::calibration::session {
namespace {

constexpr double kLasting = 2.0;  // times what a hold's poses scatter by

// Poses from the first of a hold on, as long as the marker stays where it is held.
class HoldInProgress {
 public:
  HoldInProgress(const HoldSettings& settings, Hold begun) : settings_(settings), hold_(std::move(begun)) {
    for (const auto& pose : hold_) sum(pose);
  }

  // False: the hold has ended before this pose.
  bool add(const TrackedPose& pose) {
    if (pose.time_s - hold_.back().time_s > settings_.bridged_s) return false;
    if (!pose.marker.seen) return true;
    const auto n = static_cast<double>(hold_.size());
    if ((pose.marker.translation - places_ / n).norm() > kLasting * settings_.still.place ||
        (turn_of(pose) - turns_ / n).norm() > kLasting * settings_.still.turn)
      return true;  // ends it where it goes on
    hold_.push_back(pose);
    sum(pose);
    return true;
  }

  Hold trimmed() const {
    const double from = hold_.front().time_s + settings_.trim_s, to = hold_.back().time_s - settings_.trim_s;
    Hold inner;
    for (const auto& pose : hold_)
      if (pose.time_s >= from && pose.time_s <= to) inner.push_back(pose);
    return inner;
  }

 private:
  Vector3 turn_of(const TrackedPose& pose) const {
    return so3_log(pose.marker.rotation * hold_.front().marker.rotation.conjugate());
  }
  void sum(const TrackedPose& pose) {
    places_ += pose.marker.translation;
    turns_ += turn_of(pose);
  }

  const HoldSettings& settings_;
  Hold hold_;
  Vector3 places_ = Vector3::Zero(), turns_ = Vector3::Zero();
};

// The seen poses up to `at` that lie within the stillness' window.
Hold window_before(const std::vector<TrackedPose>& poses, std::size_t at, double window_s) {
  std::size_t first = at;
  while (first > 0 && poses[first - 1].marker.seen && poses[at].time_s - poses[first - 1].time_s <= window_s)
    --first;
  return {poses.begin() + static_cast<std::ptrdiff_t>(first),
          poses.begin() + static_cast<std::ptrdiff_t>(at) + 1};
}

}  // namespace

std::vector<Hold> find_holds(const std::vector<TrackedPose>& poses, const HoldSettings& settings) {
  std::vector<Hold> holds;
  if (poses.empty()) return holds;
  Stillness still(poses.front().marker.marker, settings.still);
  std::optional<HoldInProgress> held;
  const auto end_hold = [&] {
    if (held)
      if (auto hold = held->trimmed(); hold.size() >= std::max<std::size_t>(settings.fewest, 1) &&
                                       hold.back().time_s - hold.front().time_s >= settings.least_s)
        holds.push_back(std::move(hold));
    held.reset();
  };
  for (std::size_t i = 0; i < poses.size(); ++i) {
    still.add(poses[i].marker);
    if (held && !held->add(poses[i])) end_hold();
    if (held || !poses[i].marker.seen || !still.still() || !still.moved()) continue;
    still.take();
    held.emplace(settings, window_before(poses, i, settings.still.window_s));
  }
  end_hold();
  return holds;
}

TrackedPose mean_pose(const Hold& hold) {
  TrackedPose mean = hold[hold.size() / 2];
  const auto n = static_cast<double>(hold.size());
  const Quaternion middle = mean.marker.rotation;
  Vector3 place = Vector3::Zero(), turn = Vector3::Zero(), joints = Vector3::Zero(), gimbal = Vector3::Zero();
  Matrix6 covariance = Matrix6::Zero();
  Matrix3 systematic = Matrix3::Zero();
  double time = 0.0;
  const double origin = mean.time_s;  // so that the sum keeps its digits
  for (const auto& pose : hold) {
    place += pose.marker.translation / n;
    turn += so3_log(pose.marker.rotation * middle.conjugate()) / n;
    joints += pose.joints / n;
    gimbal += pose.gimbal / n;
    covariance += pose.marker.covariance / (n * n);
    systematic += pose.marker.systematic / n;
    time += (pose.time_s - origin) / n;
  }
  mean.time_s = origin + time;
  mean.marker.translation = place;
  mean.marker.rotation = (so3_exp(turn) * middle).normalized();
  mean.marker.covariance = covariance;
  mean.marker.systematic = systematic;
  mean.joints = joints;
  mean.gimbal = gimbal;
  return mean;
}

HeldTouch touch_of(const Hold& hold, const Vector3& tip) {
  HeldTouch touch;
  touch.frames = hold.size();
  touch.from_s = hold.front().time_s;
  touch.to_s = hold.back().time_s;
  const auto [place, covariance] = mean_tip(hold, tip);
  touch.place = place;
  touch.covariance = covariance;
  for (const auto& pose : hold) {
    const Vector3 off = pose.marker.rotation * tip + pose.marker.translation - touch.place;
    touch.scatter += off * off.transpose() / std::max(1.0, static_cast<double>(hold.size()) - 1.0);
  }
  return touch;
}

std::vector<Hold> holds_at(const std::vector<Hold>& holds, const std::vector<double>& keys_s,
                           std::size_t& missed, double patience_s) {
  std::vector<Hold> meant;
  missed = 0;
  auto from = holds.begin();
  for (std::size_t i = 0; i < keys_s.size(); ++i) {
    const double key = keys_s[i];
    const double until = std::min(key + patience_s, i + 1 < keys_s.size() ? keys_s[i + 1] : key + patience_s);
    const auto at =
        std::find_if(from, holds.end(), [&](const Hold& hold) { return hold.back().time_s >= key; });
    if (at == holds.end() || at->front().time_s > until) {
      ++missed;
      continue;
    }
    meant.push_back(*at);
    from = at + 1;
  }
  return meant;
}

}  // namespace palpate::calibration::session
