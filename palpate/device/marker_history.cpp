#include "palpate/device/marker_history.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <iterator>

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

std::optional<MarkerPose> MarkerHistory::predict(Instant<GraphicsClock> time, Course course,
                                                 Duration span) const {
  if (poses_.empty() || time - poses_.back().time > longest_gap_) return std::nullopt;
  const MarkerPose& newest = poses_.back();
  const auto within = std::distance(
      poses_.rbegin(), std::find_if(poses_.rbegin(), poses_.rend(),
                                    [&](const MarkerPose& p) { return newest.time - p.time > span; }));
  if (within < 3) return std::nullopt;
  const Eigen::Index terms = course == Course::accelerating && within >= kLeastAccelerating ? 3 : 2;
  // A polynomial through (turn, shift) relative to the newest pose, over time relative to it in units of the span, which keeps
  // the equations well scaled.
  const auto powers = [&](Duration t) {
    const double x = to_seconds(t) / to_seconds(span);
    return Eigen::Vector3d(1.0, x, x * x).head(terms).eval();
  };
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(terms, terms), right = Eigen::MatrixXd::Zero(terms, 6);
  for (auto pose = poses_.rbegin(); pose != poses_.rbegin() + within; ++pose) {
    Vector6 y;
    y << so3_log(pose->rotation * newest.rotation.conjugate()), pose->translation - newest.translation;
    const Eigen::VectorXd at = powers(pose->time - newest.time);
    normal += at * at.transpose();
    right += at * y.transpose();
  }
  const Eigen::LDLT<Eigen::MatrixXd> solver(normal);
  const Eigen::VectorXd ahead = powers(time - newest.time), weights = solver.solve(ahead);
  const Vector6 y = right.transpose() * weights;
  if (!y.allFinite()) return std::nullopt;
  MarkerPose result = newest;
  result.time = time;
  result.rotation = (so3_exp(y.head<3>()) * newest.rotation).normalized();
  result.translation = newest.translation + y.tail<3>();
  // Variance of the polynomial's value at `ahead`, each pose as uncertain as the newest.
  result.covariance *= ahead.dot(weights);
  return result;
}

}  // namespace palpate::device
