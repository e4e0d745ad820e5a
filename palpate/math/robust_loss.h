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

inline double huber_weight(double length, double knee) { return length <= knee ? 1.0 : knee / length; }
inline double cauchy_weight(double squared, double c2) { return 1.0 / (1.0 + squared / c2); }

// Quadratic up to the knee, linear beyond.
inline Robust huber(double squared, double knee) {
  const double length = std::sqrt(squared);
  return {length <= knee ? squared : knee * (2.0 * length - knee), huber_weight(length, knee)};
}

// c^2 log(1 + s / c^2).
inline Robust cauchy(double squared, double c2) {
  return {c2 * std::log1p(squared / c2), cauchy_weight(squared, c2)};
}

}  // namespace palpate::inline math
