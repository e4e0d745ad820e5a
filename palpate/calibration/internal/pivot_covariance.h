// How well tip and pivots are known when samples share errors: neighbours in time do, by a drifting or
// trembling tip; poses alike do, by the tracker's bias and a hand that pulls.
//
// Parts, added: white noise, formally; a smooth field of errors over the marker's pose (smooth_error.h), half
// of it keeping to the tracker's axes (bias), half to the marker's (pull); where the tip's motion was
// subtracted, what a wrong scale and shear of the arm's readings does (`motion_strain`). The sum grows where
// a moving-block bootstrap (Kuensch 1989; 200 draws, blocks of whole residual correlations within segments)
// scatters more. Order: tip 3, then 3 per pivot. Deterministic for a seed. Metres; pure function.
#pragma once

#include <cstdint>

#include "palpate/calibration/internal/pivot_problem.h"
#include "palpate/calibration/noise/smooth_error.h"

namespace palpate::calibration {

struct PivotErrors {
  bool tip_free = true;
  bool turn_free = false;      // the motion's rotation was estimated too
  double motion_strain = 0.0;  // standard deviation of each number of the motion's 3x3 map, in parts of 1
  std::uint64_t seed = 1;      // of the bootstrap
  const noise::SmoothError* field = nullptr;  // told from more data than these; else from these
};

struct PivotCovariance {
  Eigen::MatrixXd total;                    // m^2
  Vector3 bootstrap_std = Vector3::Zero();  // m, of the tip, from the bootstrap alone
  int block = 1;                            // rows
  noise::SmoothError field;                 // m
};

PivotCovariance pivot_covariance(const PivotData& data, const std::vector<Vector3>& residuals,
                                 const PivotErrors& how);

}  // namespace palpate::calibration
