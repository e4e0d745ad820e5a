#include "palpate/calibration/internal/smooth_stream.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "palpate/core/statistics.h"

namespace palpate::calibration {
namespace {

constexpr double kWidth = 1.2;       // of the weights, in sampling periods
constexpr double kReach = 4.0;       // in widths
constexpr double kLongestGap = 3.0;  // in sampling periods, from t to the next sample on either side

}  // namespace

double sampling_period(const std::vector<double>& time_s) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < time_s.size(); ++i) steps.push_back(time_s[i] - time_s[i - 1]);
  return steps.empty() ? 0.0 : quantile(std::move(steps), 0.75);
}

SmoothStream::SmoothStream(std::vector<double> time_s, Eigen::MatrixXd channels, double width_s)
    : time_s_(std::move(time_s)),
      channels_(std::move(channels)),
      period_(sampling_period(time_s_)),
      width_(std::max(width_s, kWidth * period_)) {}

bool SmoothStream::at(double t, Eigen::RowVectorXd& value, Eigen::RowVectorXd& slope) const {
  const auto begin = time_s_.begin();
  const auto next = std::lower_bound(begin, time_s_.end(), t);
  const auto gap = kLongestGap * period_;
  // Two samples on either side, so that nothing is extrapolated.
  if (next - begin < 2 || time_s_.end() - next < 2) return false;
  if (*next - t > gap || t - *(next - 1) > gap) return false;
  const auto first = std::min(std::lower_bound(begin, next, t - kReach * width_), next - 2);
  const auto last = std::max(std::upper_bound(next, time_s_.end(), t + kReach * width_), next + 2);
  Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
  for (auto it = first; it != last; ++it) {
    const double u = (*it - t) / width_, w = std::exp(-0.5 * u * u);
    const Eigen::Vector4d z(1.0, u, u * u, u * u * u);
    moments.noalias() += w * z * z.transpose();
  }
  bool invertible = false;
  Eigen::Matrix4d inverse;
  moments.computeInverseWithCheck(inverse, invertible, 1e-12);
  if (!invertible) return false;
  value.setZero(channels_.cols());
  slope.setZero(channels_.cols());
  for (auto it = first; it != last; ++it) {
    const double u = (*it - t) / width_, w = std::exp(-0.5 * u * u);
    const Eigen::Vector4d z(1.0, u, u * u, u * u * u);
    const auto row = channels_.row(it - begin);
    value += w * inverse.row(0).dot(z) * row;
    slope += w / width_ * inverse.row(1).dot(z) * row;
  }
  return true;
}

}  // namespace palpate::calibration
