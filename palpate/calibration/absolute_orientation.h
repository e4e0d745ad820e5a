// Absolute orientation: the rotation R and translation t that carry one list of points onto another, b_i = R
// a_i + t.
//
// Least squares with optional weights: min sum w_i |b_i - R a_i - t|^2, in closed form. Metres. Pure
// functions. Covariance order: rotation 3 (rad, a turn added in B's axes: R = exp(w) R0), translation 3 (m),
// for independent errors of equal size in the b_i, that size estimated from the residuals. Refused: fewer
// than three points, points on a line, numbers that are not finite, weights that leave fewer than three,
// lists of unlike size (one in other units). Source: Arun, Huang, Blostein (1987), "Least-squares fitting of
// two 3-D point sets", with the reflection case of Umeyama (1991).
#pragma once

#include <optional>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/math/estimate.h"
#include "palpate/math/pose.h"

namespace palpate::calibration {

struct RigidTransform {
  Matrix3 rotation = Matrix3::Identity();
  Vector3 translation = Vector3::Zero();  // m
  bool mirrored = false;  // a mirror image would fit much better: one list may be left-handed or out of order
  Vector3 operator()(const Vector3& a) const { return rotation * a + translation; }
};

Expected<Estimate<RigidTransform>> absolute_orientation(const std::vector<Vector3>& from,
                                                        const std::vector<Vector3>& to,
                                                        const std::vector<double>& weights = {});

// The same without checks, covariance or residuals, for inner loops: at least three points not on a line.
RigidTransform fit_rigid(const std::vector<Vector3>& from, const std::vector<Vector3>& to,
                         const std::vector<double>& weights = {});

// The one point without which the others fit five times better and more: measured wrongly, or paired with the
// wrong one. None with fewer than five points.
std::optional<std::size_t> misplaced_point(const std::vector<Vector3>& from, const std::vector<Vector3>& to,
                                           const std::vector<double>& weights = {});

// The points that lie far off a fit that suits most: further than eight standard deviations of the median's
// kind, of at least eight points. Of few or half wrong points the fit itself is wrong, and none may be told.
std::vector<std::size_t> stray_points(const Estimate<RigidTransform>& fit,
                                      const std::vector<double>& weights = {});

// How many times as large the second list is as the first: 1 where both are in the same units of rulers that
// agree. Least squares with the rotation and translation (Umeyama 1991).
struct SizeRatio {
  double ratio = 1.0, sd = 0.0;
};
SizeRatio size_ratio(const std::vector<Vector3>& from, const std::vector<Vector3>& to,
                     const std::vector<double>& weights = {});

}  // namespace palpate::calibration
