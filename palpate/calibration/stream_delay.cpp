#include "palpate/calibration/stream_delay.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "palpate/core/statistics.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

struct Moving {
  Vector3 place, velocity;
};

// Place and velocity of the early stream at time t; empty outside it.
std::optional<Moving> at(const std::vector<TimedPoint>& stream, double t) {
  const auto after = std::upper_bound(stream.begin(), stream.end(), t,
                                      [](double time, const TimedPoint& p) { return time < p.time_s; });
  if (after == stream.begin() || after == stream.end()) return std::nullopt;
  const auto& a = *std::prev(after);
  const auto& b = *after;
  const double span = b.time_s - a.time_s;
  const double s = (t - a.time_s) / span;
  return Moving{(1 - s) * a.place + s * b.place, (b.place - a.place) / span};
}

struct Fit {
  Eigen::Vector4d x = Eigen::Vector4d::Zero();  // delay, offset
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  std::vector<Vector3> residuals;
  double cost = 0.0, speed2 = 0.0;
  int used = 0;
};

// One weighted linearisation at x; `scale` <= 0 means all weights 1.
Fit linearise(const std::vector<TimedPoint>& early, const std::vector<TimedPoint>& late,
              const Eigen::Vector4d& x, double scale, Eigen::Vector4d* gradient) {
  Fit fit;
  fit.x = x;
  gradient->setZero();
  for (const auto& point : late) {
    const auto moving = at(early, point.time_s - x[0]);
    if (!moving) continue;
    const Vector3 r = point.place - moving->place - x.tail<3>();
    Eigen::Matrix<double, 3, 4> J;  // d r / d x
    J << moving->velocity, -Matrix3::Identity();
    const double weight = scale > 0 && r.norm() > scale ? scale / r.norm() : 1.0;
    fit.normal += weight * J.transpose() * J;
    *gradient += weight * J.transpose() * r;
    fit.cost += weight * r.squaredNorm();
    fit.speed2 += moving->velocity.squaredNorm();
    fit.residuals.push_back(r);
    ++fit.used;
  }
  return fit;
}

double median_norm(const std::vector<Vector3>& residuals) {
  std::vector<double> norms;
  for (const auto& r : residuals) norms.push_back(r.norm());
  return median(std::move(norms));
}

}  // namespace

Expected<Estimate<StreamDelay>> estimate_stream_delay(const std::vector<TimedPoint>& early,
                                                      const std::vector<TimedPoint>& late,
                                                      const StreamDelayOptions& options) {
  constexpr int kNeeded = 20;
  Eigen::Vector4d gradient;
  // Start: the best of a grid as fine as a tenth of a second of motion is smooth.
  std::optional<Fit> best;
  for (double d = -options.longest_s; d <= options.longest_s; d += 0.02) {
    Eigen::Vector4d x = Eigen::Vector4d::Zero();
    x[0] = d;
    Fit fit = linearise(early, late, x, 0.0, &gradient);
    if (fit.used < kNeeded) continue;
    // best constant offset for this delay
    Vector3 mean = Vector3::Zero();
    for (const auto& r : fit.residuals) mean += r / fit.used;
    double cost = 0.0;
    for (const auto& r : fit.residuals) cost += (r - mean).squaredNorm() / fit.used;
    fit.x.tail<3>() = mean;
    fit.cost = cost;
    if (!best || cost < best->cost) best = fit;
  }
  if (!best)
    return refused(
        "delay: fewer than {} points in the two streams' common time; record them together and longer",
        kNeeded);
  const double speed = std::sqrt(best->speed2 / best->used);
  if (speed < options.needed_speed)
    return refused("delay: the tip moves at {:.3f} m/s rms, at least {:.3f} m/s are needed; move it faster",
                   speed, options.needed_speed);
  Eigen::Vector4d x = best->x;
  Fit fit;
  Estimate<StreamDelay> estimate;
  bool converged = false;
  for (int i = 0; i < 50 && !converged; ++i) {
    Fit plain = linearise(early, late, x, 0.0, &gradient);
    if (plain.used < kNeeded)
      return refused("delay: the search left the streams' common time; record them longer");
    // 1.345 standard deviations; the median norm of 3-D noise is 1.538 standard deviations per axis
    const double scale = 1.345 * std::sqrt(3.0) * median_norm(plain.residuals) / 1.538;
    fit = linearise(early, late, x, scale, &gradient);
    const Eigen::Vector4d step = -solve_symmetric(fit.normal, gradient);
    x += step;
    estimate.iterations = i + 1;
    converged = std::abs(step[0]) < 1e-9 && step.tail<3>().norm() < 1e-9;
  }
  if (!converged || std::abs(x[0]) > options.longest_s + 0.05)
    return refused(
        "delay: no delay within {:.2f} s fits the two streams; check that both saw the same motion",
        options.longest_s);
  const double variance = fit.cost / (3.0 * fit.used - 4.0);
  estimate.value = {x[0], x.tail<3>(), speed};
  estimate.covariance = variance * covariance_from_information(fit.normal);
  estimate.residuals = std::move(fit.residuals);
  estimate.termination = Termination::converged;
  return estimate;
}

}  // namespace palpate::calibration
