// The shift in time between a stream that is taken at its own samples and one that is read between its samples.
//
// Least squares on the shift alone: for each shift the response is regressed on the features, so that their
// linear relation is eliminated (variable projection, Golub and Pereyra 1973; derivative by Kaufman 1975). Noise
// is a multivariate t of five degrees of freedom, whose scatter matrix and weights are renewed with the shift
// until both stand still (Lange, Little, Taylor 1989): single blunders hardly count, and channels weigh as they
// deserve.
//
// Standard deviation: shift's error = sum g_i . w_i r_i / A. A multiplies the slopes of both streams, whose noises
// are independent; one stream's squared slopes would count its noise as motion. The variance of the sum knows
// that residuals are correlated in time: an autoregression of each whitened channel (Burg 1975, order by Akaike
// 1974) is run over the g_i; against noise that grows with the motion, the sum with Bartlett's weights (Newey and
// West 1987) of the products g_i . r_i themselves is taken where it is larger by more than its own scatter.
// Seconds; channels as given. Pure functions.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "palpate/calibration/internal/smooth_stream.h"

namespace palpate::calibration {

struct ShiftProblem {
  const std::vector<double>& time_s;   // of the sampled stream; rising
  const Eigen::MatrixXd& sampled;      // a row for each time
  const SmoothStream& sampled_smooth;  // the same stream, for its slopes
  const SmoothStream& read;            // the other stream
  bool sampled_responds = true;        // false: the sampled stream gives the features
  double independent_s = 0.0;          // time between independent samples of the motion
};

struct ShiftFit {
  double shift_s = 0.0;  // read stream's time - sampled stream's time, of one moment
  double std_s = 0.0;
  double correlation = 0.0;  // multiple, weighted
  double unexplained = 1.0;  // 1 - R^2
  double overlap_s = 0.0;
  int rows = 0;
  double effective_rows = 0.0;  // of residuals that are correlated
  double memory_s = 0.0;
  double grown_by = 1.0;
};

// From a shift that is right to `reach_s`; none where too few rows are left or no minimum is found near.
std::optional<ShiftFit> fit_shift(const ShiftProblem& problem, double shift_s, double reach_s);

}  // namespace palpate::calibration
