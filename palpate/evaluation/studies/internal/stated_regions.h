// Do the 95 % regions that a calibration states hold the truth?
//
// A region is the ellipsoid d^T C^-1 d <= 7.815 (the 95 % quantile of chi-squared with 3 degrees of freedom)
// about the estimate; C is J P J^T for a predicted tip, with P the stated covariance of the parameters and J
// the derivatives at the estimate, and the tip's own block of P for its place in the marker. World and
// TipMarker, m. Pure functions, any thread. Wrong use (exception): an estimate of other parameters than the
// joint method's with a free tip and held lengths.
#pragma once

#include "palpate/evaluation/studies/internal/arm_laboratory.h"

namespace palpate::evaluation::studies {

inline constexpr double kChiSquared3At95 = 7.815;

bool inside_region(const Vector3& error, const Matrix3& covariance);

// Of the judged places, whose readings no calibration has seen.
double share_of_places_inside(const Estimate<calibration::ArmSolution>& estimate,
                              const ArmLaboratory& laboratory);

bool tip_inside(const Estimate<calibration::ArmSolution>& estimate, const Vector3& true_tip);

}  // namespace palpate::evaluation::studies
