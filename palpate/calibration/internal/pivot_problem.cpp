#include "palpate/calibration/internal/pivot_problem.h"

#include <cmath>

#include "palpate/math/pose.h"

namespace palpate::calibration {

PivotTipSystem tip_system(const PivotData& data) {
  PivotTipSystem system;
  system.mean_R = segment_means(data, Matrix3(Matrix3::Zero()), [&](std::size_t i) { return data.R[i]; });
  const auto mean_p = segment_means(data, Vector3(Vector3::Zero()),
                                    [&](std::size_t i) { return Vector3(data.p[i] - data.motion[i]); });
  for (std::size_t i = 0; i < data.size(); ++i) {
    const Matrix3 dR = data.R[i] - system.mean_R[data.segment[i]];
    system.A += data.weight[i] * dR.transpose() * dR;
    system.b -= data.weight[i] * dR.transpose() * (data.p[i] - data.motion[i] - mean_p[data.segment[i]]);
  }
  return system;
}

std::vector<Vector3> pivots_of(const PivotData& data, const Vector3& tip) {
  return segment_means(data, Vector3(Vector3::Zero()), [&](std::size_t i) { return data.tip_at(i, tip); });
}

std::vector<Vector3> residuals_of(const PivotData& data, const Vector3& tip,
                                  const std::vector<Vector3>& pivots) {
  std::vector<Vector3> residuals;
  for (std::size_t i = 0; i < data.size(); ++i)
    residuals.push_back(pivots[data.segment[i]] - data.tip_at(i, tip));
  return residuals;
}

double largest_rotation(const PivotData& data) {
  double largest = 0.0;
  for (std::size_t s = 0; s < data.segments; ++s) {
    std::vector<Quaternion> turns;
    for (std::size_t i = 0; i < data.size(); ++i)
      if (data.segment[i] == s) turns.emplace_back(data.R[i]);
    const std::size_t stride = turns.size() / 400 + 1;  // all pairs of thousands of poses would take seconds
    // The angle between two falls with their quaternions' |dot|: one arc tangent is enough.
    std::size_t from = 0, to = 0;
    double least = 1.0;
    for (std::size_t i = 0; i < turns.size(); i += stride)
      for (std::size_t j = 0; j < i; j += stride)
        if (const double dot = std::abs(turns[i].coeffs().dot(turns[j].coeffs())); dot < least) {
          least = dot;
          from = i;
          to = j;
        }
    if (from != to) largest = std::max(largest, angle_between(turns[from], turns[to]));
  }
  return largest;
}

// 1 + 2 sum of the autocorrelation, up to where it drowns in its own noise.
double integrated_correlation(const PivotData& data, const std::vector<Vector3>& residuals) {
  double square = 0.0;
  for (const auto& r : residuals) square += r.squaredNorm();
  if (square <= 0.0) return 1.0;
  const double floor = 2.0 / std::sqrt(3.0 * static_cast<double>(data.size()));
  double sum = 1.0;
  for (std::size_t lag = 1; lag < data.size() / 4; ++lag) {
    double product = 0.0;
    for (std::size_t i = lag; i < data.size(); ++i)
      if (data.segment[i] == data.segment[i - lag]) product += residuals[i].dot(residuals[i - lag]);
    if (product / square < floor) break;
    sum += 2.0 * product / square;
  }
  return sum;
}

}  // namespace palpate::calibration
