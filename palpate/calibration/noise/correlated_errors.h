// What a smooth systematic error of the tracker adds to a covariance: residuals of near places that resemble
// each other tell how large the error is and how far it reaches, and so how much of it the fit has swallowed.
//
// Model: the whitened errors of sample i are e_i = white + field(place_i), three independent components, with
// Cov(e_i, e_j) = s^2 ((1 - share) [i = j] + share exp(-|place_i - place_j|^2 / (2 reach^2))). Share and
// reach are weighed over a grid by their restricted likelihood (Patterson, Thompson 1971), four
// on share = 0 and the rest spread evenly; the covariance of a least-squares estimate that took the errors
// for white is the weighed mean of the sandwich H^-1 J^T V J H^-1. Lengths in metres, errors in any unit.
// Pure function, deterministic. A field that shifts a marker by sd s sqrt(share) also turns it, by about that
// over the reach, and the turn moves what stands off from the marker: `levers` (the term is left out of the
// likelihood, where it changes little). Not seen by the residuals: a field so smooth that over the samples'
// extent it is one of the motions the fit allows (a shift, a turn). Only a stated accuracy tells of it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "palpate/math/so3.h"

namespace palpate::calibration::noise {

struct CorrelatedErrors {
  double share = 0.0;          // of the variance, expected
  double reach = 0.0;          // m, expected among the grid's; 0 where the errors look white
  double sigma = 0.0;          // s, expected rms per component
  Eigen::MatrixXd covariance;  // of the estimate
};

// What is stated is believed where the residuals do not speak against it: where they show less than stated,
// the fit has swallowed the rest.
struct CorrelationInput {
  std::vector<Vector3> places;  // m, of the markers
  Eigen::MatrixXd J;            // 3n x P, whitened, not scaled; rows 3i to 3i+2 belong to place i
  Eigen::VectorXd residuals;    // 3n, whitened
  std::vector<Matrix3> levers;  // whitened: how a turn of the marker (rad, World) moves the residual; or none
  Eigen::MatrixXd precision;    // P x P: the prior's information times the errors' variance; may be zero
  double stated_variance =
      0.0;  // s^2 as the tracker's maker states it, systematic part and all; 0: not stated
  std::optional<double> stated_share;  // and the systematic part's share of it
};

CorrelatedErrors correlated_covariance(const CorrelationInput& input);

}  // namespace palpate::calibration::noise
