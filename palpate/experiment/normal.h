// The standard normal distribution: its density, its tail and its quantile. Pure functions, any thread.
#pragma once

#include <cmath>
#include <numbers>

namespace palpate::experiment {

// Share below z; of a share above z ask for normal_below(-z), which keeps its digits in the far tail.
inline double normal_below(double z) { return 0.5 * std::erfc(-z / std::numbers::sqrt2); }

inline double normal_density(double z) {
  return std::exp(-0.5 * z * z) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
}

// The z below which this share lies (0 < share < 1), by halving.
inline double normal_quantile(double share) {
  double low = -40.0, high = 40.0;
  for (int i = 0; i < 100 && high - low > 1e-15; ++i) {
    const double middle = 0.5 * (low + high);
    (normal_below(middle) < share ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace palpate::experiment
