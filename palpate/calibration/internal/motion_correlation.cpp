#include "palpate/calibration/internal/motion_correlation.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "palpate/core/statistics.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

// Angular velocities on a regular grid; zero, and not valid, inside gaps of the stream.
struct Turning {
  double start_s = 0.0;
  Eigen::Matrix3Xd w;
  Eigen::VectorXd squared, valid;
};

double median_period(const std::vector<device::StampedPose>& poses) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < poses.size(); ++i) steps.push_back(poses[i].time_s - poses[i - 1].time_s);
  return median(std::move(steps));
}

Turning turning_of(const std::vector<device::StampedPose>& poses, double grid_s, double half_window_s,
                   double max_gap_s) {
  Turning result;
  result.start_s = poses.front().time_s;
  const auto n = static_cast<Eigen::Index>((poses.back().time_s - result.start_s) / grid_s) + 1;
  result.w = Eigen::Matrix3Xd::Zero(3, n);
  result.squared = result.valid = Eigen::VectorXd::Zero(n);
  const auto rotation_at = [&](double t, Quaternion& q) {
    const auto next =
        std::lower_bound(poses.begin(), poses.end(), t, [](const auto& p, double s) { return p.time_s < s; });
    if (next == poses.end() || next == poses.begin()) return false;
    const auto& a = *(next - 1);
    const double gap = next->time_s - a.time_s;
    if (gap > max_gap_s) return false;
    q = a.rotation.slerp((t - a.time_s) / gap, next->rotation);
    return true;
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = result.start_s + static_cast<double>(i) * grid_s;
    Quaternion before, after;
    if (!rotation_at(t - half_window_s, before) || !rotation_at(t + half_window_s, after)) continue;
    const Vector3 w = so3_log(before.conjugate() * after) / (2 * half_window_s);
    result.w.col(i) = w;
    result.squared(i) = w.squaredNorm();
    result.valid(i) = 1.0;
  }
  return result;
}

}  // namespace

std::vector<DelayCandidate> delay_candidates(const std::vector<device::StampedPose>& hand,
                                             const std::vector<device::StampedPose>& eye) {
  if (hand.size() < 10 || eye.size() < 10) return {};
  const double hand_s = hand.back().time_s - hand.front().time_s,
               eye_s = eye.back().time_s - eye.front().time_s;
  const double slower = std::max(median_period(hand), median_period(eye));
  // 20 ms resolves a hand's motion; long recordings take a coarser grid so that the work stays at 2e7
  // products.
  // A stream much longer than the other (one wrong time stamp does) must not fill the memory: 1e6 grid
  // points.
  const double grid = std::max({0.02, std::sqrt(hand_s * eye_s / 2e7), std::max(hand_s, eye_s) / 1e6});
  // Noise of single camera poses (a degree and more) must not drown the velocity: difference over at least
  // 0.2 s.
  const double half_window = std::max({0.1, grid, slower});
  const Turning H = turning_of(hand, grid, half_window, std::max(0.2, 3 * slower));
  const Turning E = turning_of(eye, grid, half_window, std::max(0.2, 3 * slower));
  const auto nh = H.w.cols(), ne = E.w.cols();
  const double least = std::max(20.0, 0.25 * std::min(H.valid.sum(), E.valid.sum()));

  std::vector<DelayCandidate> lags;
  for (Eigen::Index lag = -(ne - 1); lag < nh; ++lag) {
    DelayCandidate c;
    c.delay_s = H.start_s - E.start_s + static_cast<double>(lag) * grid;
    const Eigen::Index first = std::max<Eigen::Index>(0, -lag), last = std::min(ne, nh - lag),
                       n = last - first;
    const auto e_valid = E.valid.segment(first, n), h_valid = H.valid.segment(first + lag, n);
    const double both = e_valid.dot(h_valid);
    if (both >= least) {
      const double hh = H.squared.segment(first + lag, n).dot(e_valid),
                   ee = E.squared.segment(first, n).dot(h_valid);
      const Matrix3 M = H.w.middleCols(first + lag, n) * E.w.middleCols(first, n).transpose();
      const auto turn = nearest_rotation(M);
      const Vector3& s = turn.values;
      if (hh > 0 && ee > 0)
        c.correlation = (s(0) + s(1) + (turn.mirrored ? -s(2) : s(2))) / std::sqrt(hh * ee);
      c.score = std::atanh(std::min(c.correlation, 0.999999)) * std::sqrt(both);
      c.overlap_s = both * grid;
      c.R_hand_eye = Quaternion(turn.rotation);
    }
    lags.push_back(c);
  }

  std::vector<DelayCandidate> peaks;
  for (std::size_t i = 1; i + 1 < lags.size(); ++i) {
    const double a = lags[i - 1].score, b = lags[i].score, c = lags[i + 1].score;
    if (b <= 0 || b < a || b <= c) continue;
    peaks.push_back(lags[i]);
    const double bend = a - 2 * b + c;  // vertex of the parabola through three neighbours
    if (a > 0 && c > 0 && bend < 0)
      peaks.back().delay_s += std::clamp(0.5 * (a - c) / bend, -0.5, 0.5) * grid;
  }
  std::sort(peaks.begin(), peaks.end(), [](const auto& a, const auto& b) {
    return a.score != b.score ? a.score > b.score : a.delay_s < b.delay_s;
  });
  if (peaks.size() > 8) peaks.resize(8);
  return peaks;
}

}  // namespace palpate::calibration
