#include "palpate/calibration/absolute_orientation.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "palpate/calibration/noise/robust_scale.h"
#include "palpate/core/statistics.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

// Second largest extent against the largest below which points count as lying on a line.
constexpr double kLineRatio = 1e-3;
// A rotation known worse than this (one sigma, about the worst axis) is no answer.
constexpr double kWorstRotation = 0.15;  // rad
constexpr double kUnlikeSize = 2.0;      // lists of the same points in the same units differ by less

double weight_at(const std::vector<double>& weights, std::size_t i) {
  return weights.empty() ? 1.0 : weights[i];
}

Vector3 weighted_mean(const std::vector<Vector3>& points, const std::vector<double>& weights) {
  Vector3 sum = Vector3::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double w = weight_at(weights, i);
    sum += w * points[i];
    total += w;
  }
  return sum / total;
}

// Extents (standard deviations) of the cloud along its principal axes, largest first.
Vector3 extents(const std::vector<Vector3>& points, const std::vector<double>& weights) {
  const Vector3 mean = weighted_mean(points, weights);
  Matrix3 scatter = Matrix3::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double w = weight_at(weights, i);
    scatter += w * (points[i] - mean) * (points[i] - mean).transpose();
    total += w;
  }
  const Vector3 values = symmetric_eigenvalues(scatter / total);
  return values.reverse().cwiseMax(0.0).cwiseSqrt();
}

// How far the points lie around their middle: the median, which one stray point does not change.
double typical_distance(const std::vector<Vector3>& points) {
  Vector3 middle;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const auto& p : points) values.push_back(p[axis]);
    middle[axis] = median(std::move(values));
  }
  std::vector<double> distances;
  for (const auto& p : points) distances.push_back((p - middle).norm());
  return median(std::move(distances));
}

// Weighted sum of squares over degrees of freedom, m^2, of the best fit.
double variance_of_fit(const std::vector<Vector3>& from, const std::vector<Vector3>& to,
                       const std::vector<double>& weights) {
  const RigidTransform fit = fit_rigid(from, to, weights);
  double chi2 = 0.0, used = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    chi2 += weight_at(weights, i) * (to[i] - fit(from[i])).squaredNorm();
    used += weight_at(weights, i) > 0.0;
  }
  return chi2 / (3.0 * used - 6.0);
}

}  // namespace

RigidTransform fit_rigid(const std::vector<Vector3>& from, const std::vector<Vector3>& to,
                         const std::vector<double>& weights) {
  const Vector3 mean_from = weighted_mean(from, weights), mean_to = weighted_mean(to, weights);
  Matrix3 H = Matrix3::Zero();
  for (std::size_t i = 0; i < from.size(); ++i)
    H += (weight_at(weights, i)) * (to[i] - mean_to) * (from[i] - mean_from).transpose();
  const auto turn = nearest_rotation(H);
  RigidTransform result;
  // Points in a plane mirror as well as they turn; only a solid cloud tells.
  result.mirrored = turn.mirrored && turn.values[2] > 0.05 * turn.values[1];
  result.rotation = turn.rotation;
  result.translation = mean_to - result.rotation * mean_from;
  return result;
}

Expected<Estimate<RigidTransform>> absolute_orientation(const std::vector<Vector3>& from,
                                                        const std::vector<Vector3>& to,
                                                        const std::vector<double>& weights) {
  if (from.size() != to.size())
    return wrong_use("absolute orientation: {} points against {}; lists of the same length are expected",
                     from.size(), to.size());
  if (!weights.empty() && weights.size() != from.size())
    return wrong_use("absolute orientation: {} weights for {} points", weights.size(), from.size());
  std::size_t used = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const double w = weight_at(weights, i);
    if (!from[i].allFinite() || !to[i].allFinite() || !std::isfinite(w) || w < 0.0)
      return refused(
          "absolute orientation: point {} is not finite or has a negative weight; remove or repair it",
          i + 1);
    used += w > 0.0;
  }
  if (used < 3)
    return refused("absolute orientation: {}; at least 3, not on one line, are needed",
                   counted(used, "point"));
  for (const auto* points : {&from, &to}) {
    const Vector3 extent = extents(*points, weights);
    if (!(extent[1] > kLineRatio * extent[0]))
      return refused(
          "absolute orientation: the {} points lie on a line ({:.3g} mm long, {:.2g} mm wide), so the turn "
          "about it cannot be known; measure at least one point well beside it",
          points == &from ? "first" : "second", mm_from_metres(extent[0]), mm_from_metres(extent[1]));
  }
  const double ratio = typical_distance(to) / typical_distance(from);
  if (!(ratio < kUnlikeSize && ratio > 1.0 / kUnlikeSize))
    return refused(
        "absolute orientation: the second list is {:.4g} times as large as the first, the same size is "
        "expected; check the units in the headers (_mm or _m) and that the lists hold the same points",
        ratio);

  Estimate<RigidTransform> estimate;
  estimate.value = fit_rigid(from, to, weights);
  // About the middle of the points turn and shift do not mix, whatever the distance from the origin.
  const Matrix3& R = estimate.value.rotation;
  const Vector3 middle = R * weighted_mean(from, weights);
  Matrix3 turning = Matrix3::Zero();  // information on the turn
  double chi2 = 0.0, total = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const double w = weight_at(weights, i);
    const Vector3 turned = R * from[i];
    estimate.residuals.push_back(to[i] - turned - estimate.value.translation);
    chi2 += w * estimate.residuals.back().squaredNorm();
    turning += w * hat(turned - middle).transpose() * hat(turned - middle);
    total += w;
  }
  const double variance = chi2 / (3.0 * static_cast<double>(used) - 6.0);
  const auto turn = symmetric_eigen(variance * covariance_from_information(turning));
  const double worst = std::sqrt(turn.values[2]);
  if (!(worst <= kWorstRotation) && estimate.value.mirrored)
    return refused(
        "absolute orientation: the points fit badly (rms {:.3g} mm) and their mirror image fits better; one "
        "list is left-handed or not in the other's order",
        mm_from_metres(rms_per_component(estimate.residuals)));
  if (!(worst <= kWorstRotation))
    return refused(
        "absolute orientation: the points are too close to a line or fit too badly (rms {:.3g} mm): the "
        "rotation is known to {:.0f} deg only; spread the points and check their order",
        mm_from_metres(rms_per_component(estimate.residuals)), degrees_from_radians(worst));
  // The translation is the origin's: the middle's shift and, across the lever, the turn.
  const Matrix3 root = turn.vectors * turn.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
  Eigen::Matrix<double, 6, 3> by_turn;
  by_turn << root, hat(middle) * root;
  estimate.covariance = by_turn * by_turn.transpose();
  estimate.covariance.bottomRightCorner<3, 3>() += variance / total * Matrix3::Identity();
  const Vector3 extent = extents(from, weights);
  estimate.condition = extent[0] / extent[1];
  return estimate;
}

std::optional<std::size_t> misplaced_point(const std::vector<Vector3>& from, const std::vector<Vector3>& to,
                                           const std::vector<double>& weights) {
  constexpr double kBetter = 25.0;        // in variance: five times in rms
  constexpr std::size_t kFewest = 5;      // what is left must still be judged
  constexpr std::size_t kMostTried = 20;  // the worst fitting ones; a stray point is among them
  if (from.size() < kFewest || from.size() != to.size()) return std::nullopt;
  // Where they fit to rounding alone none is worse than another.
  constexpr double kRounding = 1e-16;  // of the variance of the points: 1e-8 of their spread
  Vector3 middle = Vector3::Zero();
  for (const auto& p : from) middle += p / static_cast<double>(from.size());
  double spread = 0.0;
  for (const auto& p : from) spread += (p - middle).squaredNorm() / static_cast<double>(from.size());
  if (!(variance_of_fit(from, to, weights) > kRounding * spread)) return std::nullopt;
  const RigidTransform all = fit_rigid(from, to, weights);
  std::vector<std::pair<double, std::size_t>> worst;
  for (std::size_t i = 0; i < from.size(); ++i)
    if (weight_at(weights, i) > 0.0) worst.emplace_back(-(to[i] - all(from[i])).squaredNorm(), i);
  if (worst.size() < kFewest) return std::nullopt;
  std::sort(worst.begin(), worst.end());
  worst.resize(std::min(worst.size(), kMostTried));
  double least = variance_of_fit(from, to, weights) / kBetter;
  std::optional<std::size_t> found;
  for (const auto& [fit, i] : worst) {
    auto others = weights.empty() ? std::vector<double>(from.size(), 1.0) : weights;
    others[i] = 0.0;
    if (const double without = variance_of_fit(from, to, others); without < least) least = without, found = i;
  }
  return found;
}

std::vector<std::size_t> stray_points(const Estimate<RigidTransform>& fit,
                                      const std::vector<double>& weights) {
  constexpr double kFar = 8.0;
  constexpr std::size_t kFewest = 8;
  std::vector<double> errors;
  for (std::size_t i = 0; i < fit.residuals.size(); ++i)
    errors.push_back(std::sqrt(weight_at(weights, i)) * fit.residuals[i].norm());
  std::vector<std::size_t> stray;
  if (errors.size() < kFewest) return stray;
  const double sd = noise::robust_scale(errors, 6.0);
  for (std::size_t i = 0; i < errors.size(); ++i)
    if (errors[i] > kFar * sd) stray.push_back(i);
  return stray;
}

SizeRatio size_ratio(const std::vector<Vector3>& from, const std::vector<Vector3>& to,
                     const std::vector<double>& weights) {
  const RigidTransform fit = fit_rigid(from, to, weights);
  const Vector3 mean_from = weighted_mean(from, weights), mean_to = weighted_mean(to, weights);
  double along = 0.0, squares = 0.0, chi2 = 0.0, used = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vector3 a = fit.rotation * (from[i] - mean_from), b = to[i] - mean_to;
    along += weight_at(weights, i) * a.dot(b);
    squares += weight_at(weights, i) * a.squaredNorm();
  }
  const double ratio = along / squares;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Vector3 a = fit.rotation * (from[i] - mean_from), b = to[i] - mean_to;
    chi2 += weight_at(weights, i) * (b - ratio * a).squaredNorm();
    used += weight_at(weights, i) > 0.0;
  }
  return {ratio, std::sqrt(chi2 / std::max(1.0, 3.0 * used - 7.0) / squares)};
}

}  // namespace palpate::calibration
