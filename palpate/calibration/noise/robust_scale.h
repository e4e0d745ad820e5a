// Robust statistics of vector residuals: scale from the median, weights of Huber (1964) and Tukey (1974).
//
// The residuals are 3-vectors with independent, equal, normal components: their length then follows a chi
// distribution with 3 degrees of freedom, whose median is 1.5382.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "palpate/core/statistics.h"
#include "palpate/math/robust_loss.h"

namespace palpate::calibration::noise {

inline constexpr double kMedianOfChi3 = 1.5382;
// Lengths in units of the scale: 2.8 is exceeded by 5 % of good residuals, 5 by one in 65000.
inline constexpr double kHuberKnee = 2.8;
inline constexpr double kTukeyEnd = 5.0;
// Below this the data are exact and only rounding is left.
inline constexpr double kLeastScale = 1e-12;  // m

// Standard deviation per component, from the lengths; `parameters` of the residuals' components were fitted.
inline double robust_scale(std::vector<double> lengths, double parameters) {
  if (lengths.empty()) return kLeastScale;
  const double n = 3.0 * static_cast<double>(lengths.size());
  return std::max(kLeastScale,
                  median(std::move(lengths)) / kMedianOfChi3 * std::sqrt(n / std::max(1.0, n - parameters)));
}
inline double robust_scale(const std::vector<Eigen::Vector3d>& residuals, double parameters) {
  std::vector<double> lengths;
  lengths.reserve(residuals.size());
  for (const auto& r : residuals) lengths.push_back(r.norm());
  return robust_scale(std::move(lengths), parameters);
}

inline double huber_weight(double length, double scale) {
  return math::huber_weight(length, kHuberKnee * scale);
}

inline double tukey_weight(double length, double scale) {
  const double u = length / (kTukeyEnd * scale);
  return u >= 1.0 ? 0.0 : (1.0 - u * u) * (1.0 - u * u);
}

}  // namespace palpate::calibration::noise
