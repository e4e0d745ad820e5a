#include "palpate/calibration/internal/pivot_motion.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "palpate/calibration/absolute_orientation.h"
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

Vector3 solve_with_motion(PivotData& data, const TipMotion& arm, Quaternion& turn, double& delay) {
  constexpr double kDelay = 0.02;  // s
  std::fill(data.motion.begin(), data.motion.end(), Vector3::Zero());
  const auto at_rest = tip_system(data);
  Vector3 tip = solve_symmetric(at_rest.A, at_rest.b);
  const auto moved_from = pivots_of(data, tip);
  std::vector<Vector3> moved;
  for (std::size_t i = 0; i < data.size(); ++i)
    moved.push_back(data.tip_at(i, tip) - moved_from[data.segment[i]]);
  turn = Quaternion(fit_rigid(arm.centred, moved, data.weight).rotation);
  delay = 0.0;
  using Row = Eigen::Matrix<double, 3, 8>;  // tip, turn, delay, residual
  for (int round = 0; round < 200; ++round) {
    std::vector<Row> rows;
    double square = 0.0, used = 0.0;
    for (std::size_t i = 0; i < data.size(); ++i) {
      data.motion[i] = turn * (arm.centred[i] + delay * arm.rate[i]);
      Row row;
      row << -data.R[i], -hat(data.motion[i]), turn * arm.rate[i], -data.tip_at(i, tip);
      rows.push_back(row);
    }
    const auto mean = segment_means(data, Row(Row::Zero()), [&](std::size_t i) { return rows[i]; });
    Eigen::Matrix<double, 8, 8> N = Eigen::Matrix<double, 8, 8>::Zero();
    for (std::size_t i = 0; i < data.size(); ++i) {
      const Row row = rows[i] - mean[data.segment[i]];
      N += data.weight[i] * row.transpose() * row;
      square += data.weight[i] * row.col(7).squaredNorm(), used += 3.0 * data.weight[i];
    }
    const double prior = square / std::max(used, 1.0) / (kDelay * kDelay);
    N(6, 6) += prior + 1e-300, N(6, 7) += prior * delay;
    const Eigen::Matrix<double, 7, 1> step =
        -solve_symmetric(N.topLeftCorner<7, 7>(), N.topRightCorner<7, 1>());
    tip += step.head<3>();
    turn = (so3_exp(step.segment<3>(3)) * turn).normalized();
    delay += step[6];
    for (std::size_t i = 0; i < data.size(); ++i)
      data.motion[i] = turn * (arm.centred[i] + delay * arm.rate[i]);
    if (step.head<3>().norm() < 1e-12 && std::abs(step[6]) < 1e-9) break;
  }
  data.rate.clear();
  for (const auto& rate : arm.rate) data.rate.push_back(turn * rate);
  return tip;
}

}  // namespace palpate::calibration
