// The chi-square distribution: its tails and quantiles.
//
// Tails by the series and the continued fraction of the incomplete gamma function (Abramowitz & Stegun 6.5.29, 6.5.31),
// quantiles by halving; degrees need not be whole. Pure functions, any thread.
#pragma once

#include <cmath>

namespace palpate::inline math {

// Shares of the chi-square distribution below x and above it, each to some 1e-12 of itself.
struct ChiSquareTails {
  double below, above;
};
inline ChiSquareTails chi_square_tails(double x, double degrees) {
  const double a = 0.5 * degrees, z = 0.5 * x;
  if (!(z > 0.0)) return {0.0, 1.0};
  const double front = std::exp(a * std::log(z) - z - std::lgamma(a));
  if (z < a + 1.0) {
    double term = 1.0 / a, sum = term;
    for (double n = a + 1.0; term > 1e-17 * sum; n += 1.0) sum += term *= z / n;
    return {front * sum, 1.0 - front * sum};
  }
  // Lentz's way through 1 / (z + 1 - a - 1 (1 - a) / (z + 3 - a - ...)).
  double b = z + 1.0 - a, c = 1e300, d = 1.0 / b, value = d;
  for (int i = 1; i < 100000; ++i) {
    const double numerator = -i * (i - a);
    b += 2.0;
    d = 1.0 / (numerator * d + b);
    c = b + numerator / c;
    value *= d * c;
    if (std::abs(d * c - 1.0) < 1e-15) break;
  }
  return {1.0 - front * value, front * value};
}

// Below which a share `tail` lies, or above which, where `upper`.
inline double chi_square_quantile(double tail, double degrees, bool upper = false) {
  double low = 0.0, high = degrees + 1.0;
  const auto beyond = [&](double x) {
    const auto tails = chi_square_tails(x, degrees);
    return upper ? tails.above < tail : tails.below > tail;
  };
  while (!beyond(high)) high *= 2.0;
  for (int i = 0; i < 200 && high - low > 1e-13 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (beyond(middle) ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace palpate::inline math
