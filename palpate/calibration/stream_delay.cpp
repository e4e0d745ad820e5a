#include "palpate/calibration/stream_delay.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "palpate/calibration/noise/robust_scale.h"
#include "palpate/core/statistics.h"
#include "palpate/math/levenberg_marquardt.h"

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

// Of the late stream about the early one, shifted by x: delay in s, then the offset in m.
std::vector<Vector3> residuals_at(const std::vector<TimedPoint>& early, const std::vector<TimedPoint>& late,
                                  const Eigen::Vector4d& x) {
  std::vector<Vector3> residuals;
  for (const auto& point : late)
    if (const auto moving = at(early, point.time_s - x[0]))
      residuals.push_back(point.place - moving->place - x.tail<3>());
  return residuals;
}

// Mean loss per point, so that delays at which fewer points count are not favoured; infinite without points.
double delay_cost(const std::vector<TimedPoint>& early, const std::vector<TimedPoint>& late,
                  const Eigen::Vector4d& x, double knee, NormalEquations<4>* equations) {
  double sum = 0.0;
  int used = 0;
  for (const auto& point : late) {
    const auto moving = at(early, point.time_s - x[0]);
    if (!moving) continue;
    ++used;
    const Vector3 r = point.place - moving->place - x.tail<3>();
    const Robust robust = huber(r.squaredNorm(), knee);
    sum += robust.loss;
    if (!equations) continue;
    Eigen::Matrix<double, 3, 4> J;  // d r / d x
    J << moving->velocity, -Matrix3::Identity();
    equations->add(J, r, robust.weight);
  }
  if (used == 0) return std::numeric_limits<double>::infinity();
  if (equations) equations->JtJ /= used, equations->Jtr /= used;
  return sum / used;
}

double median_norm(const std::vector<Vector3>& residuals) {
  std::vector<double> norms;
  for (const auto& r : residuals) norms.push_back(r.norm());
  return median(std::move(norms));
}

// 1.345 standard deviations; the median norm of 3-D noise is 1.538 standard deviations per axis.
double knee_for(const std::vector<Vector3>& residuals) {
  return 1.345 * std::sqrt(3.0) * median_norm(residuals) / noise::kMedianOfChi3;
}

constexpr std::size_t kNeeded = 20;  // points in the streams' common time

// The best of a grid as fine as a tenth of a second of motion is smooth; empty where the streams do not meet.
std::optional<Eigen::Vector4d> best_of_grid(const std::vector<TimedPoint>& early,
                                            const std::vector<TimedPoint>& late, double longest_s) {
  std::optional<Eigen::Vector4d> best;
  double least = 0.0;
  for (double d = -longest_s; d <= longest_s; d += 0.02) {
    Eigen::Vector4d x(d, 0.0, 0.0, 0.0);
    const auto residuals = residuals_at(early, late, x);
    if (residuals.size() < kNeeded) continue;
    const double n = static_cast<double>(residuals.size());
    Vector3 mean = Vector3::Zero();  // the best constant offset for this delay
    for (const auto& r : residuals) mean += r / n;
    double cost = 0.0;
    for (const auto& r : residuals) cost += (r - mean).squaredNorm() / n;
    x.tail<3>() = mean;
    if (best && !(cost < least)) continue;
    best = x;
    least = cost;
  }
  return best;
}

// m/s rms of the early stream where the late one is compared with it.
double speed_at(const std::vector<TimedPoint>& early, const std::vector<TimedPoint>& late, double delay) {
  double sum = 0.0;
  int used = 0;
  for (const auto& point : late)
    if (const auto moving = at(early, point.time_s - delay)) sum += moving->velocity.squaredNorm(), ++used;
  return std::sqrt(sum / used);
}

}  // namespace

Expected<Estimate<StreamDelay>> estimate_stream_delay(const std::vector<TimedPoint>& early,
                                                      const std::vector<TimedPoint>& late,
                                                      const StreamDelayOptions& options) {
  const auto start = best_of_grid(early, late, options.longest_s);
  if (!start)
    return refused(
        "delay: fewer than {} points in the two streams' common time; record them together and longer",
        kNeeded);
  const double speed = speed_at(early, late, (*start)[0]);
  if (speed < options.needed_speed)
    return refused("delay: the tip moves at {:.3f} m/s rms, at least {:.3f} m/s are needed; move it faster",
                   speed, options.needed_speed);
  Eigen::Vector4d x = *start;
  Estimate<StreamDelay> estimate;
  double knee = 0.0;
  bool settled = false;
  // The loss's width and the delay in turn, until both stand still.
  for (int round = 0; round < 50 && !settled; ++round) {
    const auto residuals = residuals_at(early, late, x);
    if (residuals.size() < kNeeded)
      return refused("delay: the search left the streams' common time; record them longer");
    knee = knee_for(residuals);
    const Eigen::Vector4d before = x;
    const auto evaluate = [&](const Eigen::Vector4d& y, NormalEquations<4>* equations) {
      return delay_cost(early, late, y, knee, equations);
    };
    estimate.iterations += minimise(x, evaluate).iterations;
    settled = std::abs(x[0] - before[0]) < 1e-9 && (x - before).tail<3>().norm() < 1e-9;
  }
  if (!settled || std::abs(x[0]) > options.longest_s + 0.05)
    return refused(
        "delay: no delay within {:.2f} s fits the two streams; check that both saw the same motion",
        options.longest_s);
  estimate.residuals = residuals_at(early, late, x);
  NormalEquations<4> found;
  delay_cost(early, late, x, knee, &found);
  const double n = static_cast<double>(estimate.residuals.size());
  double weighted = 0.0;
  for (const auto& r : estimate.residuals) weighted += huber(r.squaredNorm(), knee).weight * r.squaredNorm();
  estimate.value = {x[0], x.tail<3>(), speed};
  estimate.covariance = weighted / (3.0 * n - 4.0) * covariance_from_information(n * found.JtJ);
  estimate.termination = Termination::converged;
  return estimate;
}

double delay_of_systematic(const std::vector<TimedPoint>& points, double systematic, double reach) {
  constexpr std::size_t kMostPlaces = 300, kFewestPlaces = 5;
  const std::size_t every = 1 + points.size() / kMostPlaces;
  std::vector<Vector3> places, speeds;
  for (std::size_t i = every; i + every < points.size(); i += every) {
    const double takes = points[i + every].time_s - points[i - every].time_s;
    if (!(takes > 0.0)) continue;
    places.push_back(points[i].place);
    speeds.push_back((points[i + every].place - points[i - every].place) / takes);
  }
  if (places.size() < kFewestPlaces) return 0.0;
  const auto n = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixXd w(n, 3), K(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& here = places[static_cast<std::size_t>(i)];
    w.row(i) = speeds[static_cast<std::size_t>(i)].transpose();
    for (Eigen::Index j = 0; j <= i; ++j)
      K(i, j) = K(j, i) =
          std::exp(-0.5 * (here - places[static_cast<std::size_t>(j)]).squaredNorm() / (reach * reach));
  }
  w.rowwise() -= Eigen::RowVector3d(w.colwise().mean());
  const double motion = w.squaredNorm();
  if (!(motion > 0.0)) return 0.0;
  return systematic * std::sqrt(std::max(0.0, w.cwiseProduct(K * w).sum())) / motion;
}

}  // namespace palpate::calibration
