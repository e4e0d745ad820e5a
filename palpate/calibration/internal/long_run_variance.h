// The variance of a weighted sum of a stationary, correlated series.
//
// An autoregression is fitted to the series (Burg 1975, "Maximum entropy spectral analysis"; order by Akaike's
// criterion, 1974), and the weights are filtered by it: sum g_i e_i = sum v_k white_k, with v the weights run
// backwards through the autoregression. Pure functions; any units.
#pragma once

#include <Eigen/Core>

namespace palpate::calibration {

struct Autoregression {
  Eigen::VectorXd coefficient;  // e_i = sum_p coefficient_p e_(i - 1 - p) + white; empty for white noise
  double white_variance = 0.0;
};

Autoregression fit_autoregression(const Eigen::VectorXd& series, Eigen::Index most_coefficients);

double variance_of_sum(const Autoregression& noise, const Eigen::VectorXd& weights);

// How many samples apart the noise has forgotten itself: half of (1 + 2 sum of its correlations) - 1/2, from the
// spectrum at zero; 0 for white noise.
double memory_of(const Autoregression& noise, double variance);

// sum_i sum_j bartlett(i - j) s_i s_j with a reach of `reach` samples.
double bartlett_sum(const Eigen::VectorXd& series, Eigen::Index reach);

}  // namespace palpate::calibration
