// What a calibration gives back: a value that knows how good it is.
//
// `covariance` is that of the tangent vector the estimator names (units in its header); directions the data
// cannot see are listed in `unobservable` and carry no variance there. Values, no thread rule.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

namespace palpate::inline math {

enum class Termination { closed_form, converged, iteration_limit };

template <typename T>
struct Estimate {
  T value{};
  Eigen::MatrixXd covariance;              // tangent order and units: see the estimator
  std::vector<Eigen::Vector3d> residuals;  // metres, one per observation, unweighted
  std::vector<bool> inlier;                // same order; empty where the estimator has no outlier rule
  double condition = 0.0;                  // of the scaled normal equations; large = the data barely carry it
  std::vector<std::string> unobservable;   // names of directions held fixed
  Termination termination = Termination::closed_form;
  int iterations = 0;

  double standard_deviation(Eigen::Index i) const { return std::sqrt(covariance(i, i)); }
};

// rms per component: sqrt(sum |r|^2 / 3N); 0 for none.
inline double rms_per_component(const std::vector<Eigen::Vector3d>& residuals) {
  double sum = 0.0;
  for (const auto& r : residuals) sum += r.squaredNorm();
  return residuals.empty() ? 0.0 : std::sqrt(sum / (3.0 * static_cast<double>(residuals.size())));
}

inline double mean_norm(const std::vector<Eigen::Vector3d>& residuals) {
  double sum = 0.0;
  for (const auto& r : residuals) sum += r.norm();
  return residuals.empty() ? 0.0 : sum / static_cast<double>(residuals.size());
}

}  // namespace palpate::inline math
