#include "palpate/calibration/internal/long_run_variance.h"

#include <algorithm>
#include <cmath>

namespace palpate::calibration {

Autoregression fit_autoregression(const Eigen::VectorXd& series, Eigen::Index most_coefficients) {
  const Eigen::Index n = series.size();
  Autoregression best;
  if (n == 0) return best;
  const auto count = static_cast<double>(n);
  double variance = series.squaredNorm() / count;
  best.white_variance = variance;
  double least = count * std::log(std::max(variance, 1e-300));
  Eigen::VectorXd forward = series, backward = series, a;
  for (Eigen::Index order = 1; order <= std::min(most_coefficients, n / 4); ++order) {
    const Eigen::Index m = n - order;
    const Eigen::VectorXd f = forward.tail(forward.size() - 1).head(m), b = backward.head(m);
    const double energy = f.squaredNorm() + b.squaredNorm();
    if (!(energy > 0.0)) break;
    const double reflection = 2.0 * f.dot(b) / energy;
    Eigen::VectorXd longer(order);
    for (Eigen::Index p = 0; p + 1 < order; ++p) longer[p] = a[p] - reflection * a[order - 2 - p];
    longer[order - 1] = reflection;
    a = longer;
    forward = f - reflection * b;
    backward = b - reflection * f;
    variance *= 1.0 - reflection * reflection;
    const double criterion = count * std::log(std::max(variance, 1e-300)) + 2.0 * static_cast<double>(order);
    if (criterion >= least) continue;
    least = criterion;
    best = {a, variance};
  }
  return best;
}

double variance_of_sum(const Autoregression& noise, const Eigen::VectorXd& weights) {
  const Eigen::Index n = weights.size(), order = noise.coefficient.size();
  // Noise before the first sample reaches into the series, too: the recursion goes on in front of it.
  const Eigen::Index before = order == 0 ? 0 : n;
  Eigen::VectorXd v = Eigen::VectorXd::Zero(n + before);
  for (Eigen::Index k = n + before - 1; k >= 0; --k) {
    double value = k >= before ? weights[k - before] : 0.0;
    for (Eigen::Index p = 0; p < order && k + 1 + p < n + before; ++p)
      value += noise.coefficient[p] * v[k + 1 + p];
    v[k] = value;
  }
  return noise.white_variance * v.squaredNorm();
}

double memory_of(const Autoregression& noise, double variance) {
  if (noise.coefficient.size() == 0 || !(variance > 0.0)) return 0.0;
  const double gain = 1.0 - noise.coefficient.sum();
  return std::max(0.0, 0.5 * (noise.white_variance / (gain * gain * variance) - 1.0));
}

double bartlett_sum(const Eigen::VectorXd& series, Eigen::Index reach) {
  double sum = series.squaredNorm();
  for (Eigen::Index lag = 1; lag <= std::min(reach, series.size() - 1); ++lag) {
    const Eigen::Index m = series.size() - lag;
    sum += 2.0 * (1.0 - static_cast<double>(lag) / static_cast<double>(reach + 1)) *
           series.head(m).dot(series.tail(m));
  }
  return sum;
}

}  // namespace palpate::calibration
