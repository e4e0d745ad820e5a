// At which lags two streams of channels might show the same motion: the coarse start of a motion's delay.
//
// Both streams' rates of change (differences over a fifth of a second or more) lie on one grid. At every lag with
// overlap the response's rates are regressed on the features' by least squares; R^2, less what chance gives with
// as many features, and the number n of independent samples give the score -n/2 log(1 - R^2), the logarithm of a
// likelihood ratio. Rates, because places drift and any two drifts correlate; n by Bartlett (1946) from
// both autocorrelations. All sums of all lags are correlations, found by Fourier transforms. Gaps count for
// nothing. Pure function.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace palpate::calibration {

struct LagStream {
  const std::vector<double>& time_s;  // rising
  const Eigen::MatrixXd& channels;    // a row for each time, the largest channels first
};

struct LagPeak {
  double lag_s = 0.0;        // response time = features' time + lag
  double correlation = 0.0;  // of the rates; multiple, less chance
  double score = 0.0;
};

struct LagSearch {
  std::vector<LagPeak> peaks;  // local maxima, best first, at most ten
  double chance_score = 0.0;   // what the best of as many lags of unrelated streams seldom exceeds
  double grid_s = 0.0;
  double independent_s = 0.0;  // time between independent samples
};

LagSearch search_lags(const LagStream& features, const LagStream& response, double longest_s);

}  // namespace palpate::calibration
