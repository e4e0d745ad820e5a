// The linear algebra of pivot calibration: R_i t + p_i = c_s + motion_i over the used poses, the pivots c_s
// eliminated. Metres; pure functions. Symbols: pivot.h.
#pragma once

#include <algorithm>
#include <vector>

#include "palpate/math/so3.h"

namespace palpate::calibration {

// The used poses, with what the linear algebra needs.
struct PivotData {
  std::vector<Matrix3> R;
  std::vector<Vector3> p;
  std::vector<Vector3> motion;  // A (g_i - mean), zero without motion
  std::vector<Vector3> rate;    // m/s, of it; none where not subtracted
  std::vector<std::size_t> segment;
  std::vector<double> weight;
  std::size_t segments = 0;

  std::size_t size() const { return R.size(); }
  Vector3 tip_at(std::size_t i, const Vector3& t) const { return R[i] * t + p[i] - motion[i]; }
};

// Weighted mean over each segment of what `of(i)` gives.
template <typename Value, typename F>
std::vector<Value> segment_means(const PivotData& data, const Value& zero, F of) {
  std::vector<Value> sum(data.segments, zero);
  std::vector<double> total(data.segments, 0.0);
  for (std::size_t i = 0; i < data.size(); ++i) {
    sum[data.segment[i]] += data.weight[i] * of(i);
    total[data.segment[i]] += data.weight[i];
  }
  for (std::size_t s = 0; s < data.segments; ++s) sum[s] /= std::max(total[s], 1e-300);
  return sum;
}

struct PivotTipSystem {  // A t = b, the pivots eliminated
  Matrix3 A = Matrix3::Zero();
  Vector3 b = Vector3::Zero();
  std::vector<Matrix3> mean_R;
};

PivotTipSystem tip_system(const PivotData& data);
std::vector<Vector3> pivots_of(const PivotData& data, const Vector3& tip);
// c_s - (R_i t + p_i - motion_i)
std::vector<Vector3> residuals_of(const PivotData& data, const Vector3& tip,
                                  const std::vector<Vector3>& pivots);
// rad, between two poses of one segment
double largest_rotation(const PivotData& data);
// Of the residuals, within segments: 1 for white noise.
double integrated_correlation(const PivotData& data, const std::vector<Vector3>& residuals);

}  // namespace palpate::calibration
