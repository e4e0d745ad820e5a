#include "palpate/calibration/internal/pivot_motion.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "palpate/calibration/absolute_orientation.h"
#include "palpate/math/levenberg_marquardt.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

constexpr double kLongestStep = 0.5;  // s, over which a difference still tells a speed

// Of a motion at these times, by differences over both neighbours within a segment; zero without times.
std::vector<Vector3> rates_of(const PivotData& data, const std::vector<Vector3>& motion,
                              const std::vector<double>& time_s) {
  std::vector<Vector3> rates(motion.size(), Vector3::Zero());
  if (time_s.size() != motion.size()) return rates;
  std::vector<std::size_t> order(motion.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return time_s[a] < time_s[b]; });
  for (std::size_t k = 1; k + 1 < order.size(); ++k) {
    const std::size_t a = order[k - 1], b = order[k + 1], i = order[k];
    const double span = time_s[b] - time_s[a];
    if (data.segment[a] != data.segment[i] || data.segment[b] != data.segment[i]) continue;
    if (span > 0.0 && span < kLongestStep) rates[i] = (motion[b] - motion[a]) / span;
  }
  return rates;
}

}  // namespace

TipMotion tip_motion(const PivotData& data, const std::vector<Vector3>& motion,
                     const std::vector<double>& time_s) {
  TipMotion arm;
  const auto mean = segment_means(data, Vector3(Vector3::Zero()), [&](std::size_t i) { return motion[i]; });
  for (std::size_t i = 0; i < data.size(); ++i) arm.centred.push_back(motion[i] - mean[data.segment[i]]);
  arm.rate = rates_of(data, motion, time_s);
  return arm;
}

namespace {

struct MotionState {
  Vector3 tip = Vector3::Zero();
  Quaternion turn = Quaternion::Identity();
  double delay = 0.0;

  MotionState moved(const Eigen::Matrix<double, 7, 1>& step) const {
    return {tip + step.head<3>(), (so3_exp(step.segment<3>(3)) * turn).normalized(), delay + step[6]};
  }
};

void set_motion(PivotData& data, const TipMotion& arm, const MotionState& x) {
  for (std::size_t i = 0; i < data.size(); ++i)
    data.motion[i] = x.turn * (arm.centred[i] + x.delay * arm.rate[i]);
}

// Of the tips about their segments' means, weighted; `stiffness` holds the delay near zero.
double motion_cost(PivotData& data, const TipMotion& arm, const MotionState& x, double stiffness,
                   NormalEquations<7>* equations) {
  using Row = Eigen::Matrix<double, 3, 8>;  // tip, turn, delay; residual
  set_motion(data, arm, x);
  std::vector<Row> rows(data.size());
  for (std::size_t i = 0; i < data.size(); ++i)
    rows[i] << data.R[i], hat(data.motion[i]), x.turn * -arm.rate[i], data.tip_at(i, x.tip);
  const auto mean = segment_means(data, Row(Row::Zero()), [&](std::size_t i) { return rows[i]; });
  double cost = stiffness * x.delay * x.delay;
  for (std::size_t i = 0; i < data.size(); ++i) {
    const Row row = rows[i] - mean[data.segment[i]];
    cost += data.weight[i] * row.col(7).squaredNorm();
    if (equations) equations->add(row.leftCols<7>(), row.col(7), data.weight[i]);
  }
  if (equations) equations->JtJ(6, 6) += stiffness, equations->Jtr[6] += stiffness * x.delay;
  return cost;
}

}  // namespace

Vector3 solve_with_motion(PivotData& data, const TipMotion& arm, Quaternion& turn, double& delay) {
  constexpr double kDelay = 0.02;  // s
  std::fill(data.motion.begin(), data.motion.end(), Vector3::Zero());
  const auto at_rest = tip_system(data);
  MotionState x;
  x.tip = solve_symmetric(at_rest.A, at_rest.b);
  const auto moved_from = pivots_of(data, x.tip);
  std::vector<Vector3> moved;
  for (std::size_t i = 0; i < data.size(); ++i)
    moved.push_back(data.tip_at(i, x.tip) - moved_from[data.segment[i]]);
  x.turn = Quaternion(fit_rigid(arm.centred, moved, data.weight).rotation);
  const double used = 3.0 * std::accumulate(data.weight.begin(), data.weight.end(), 0.0);
  // What is expected of the delay is weighed against the residuals, which depend on it: in turn, until both
  // stand still.
  for (int round = 0; round < 50; ++round) {
    const MotionState before = x;
    const double variance = motion_cost(data, arm, x, 0.0, nullptr) / std::max(used, 1.0);
    const double stiffness = variance / (kDelay * kDelay) + 1e-300;
    minimise<7>(
        x,
        [&](const MotionState& at, NormalEquations<7>* equations) {
          return motion_cost(data, arm, at, stiffness, equations);
        },
        [](const MotionState& at, const Eigen::Matrix<double, 7, 1>& step) { return at.moved(step); });
    if ((x.tip - before.tip).norm() < 1e-12 && std::abs(x.delay - before.delay) < 1e-9) break;
  }
  turn = x.turn;
  delay = x.delay;
  set_motion(data, arm, x);
  data.rate.clear();
  for (const auto& rate : arm.rate) data.rate.push_back(turn * rate);
  return x.tip;
}

}  // namespace palpate::calibration
