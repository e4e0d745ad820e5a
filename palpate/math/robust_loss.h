// Robust losses: what a squared residual s = r^2 (whitened, or of the unit that the loss's width is of)
// adds to the cost, and the weight with which it then counts in the normal equations, the loss's derivative
// by s (iteratively reweighted least squares). Pure functions.
// Sources: Huber (1964), "Robust estimation of a location parameter"; Holland, Welsch (1977), "Robust
// regression using iteratively reweighted least-squares" for Cauchy's.
#pragma once

#include <cmath>

namespace palpate::inline math {

struct Robust {
  double loss = 0.0;
  double weight = 1.0;
};

// Quadratic up to the knee, linear beyond.
inline Robust huber(double squared, double knee) {
  const double length = std::sqrt(squared);
  if (length <= knee) return {squared, 1.0};
  return {knee * (2.0 * length - knee), knee / length};
}

// c^2 log(1 + s / c^2).
inline Robust cauchy(double squared, double c2) {
  return {c2 * std::log1p(squared / c2), 1.0 / (1.0 + squared / c2)};
}

}  // namespace palpate::inline math
