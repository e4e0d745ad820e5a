#include "palpate/physics/deformable/surface_stress.h"

#include <algorithm>
#include <cmath>

namespace palpate::physics::deformable {
namespace {

// Along the normal, for principal stretches whose squares sum to `sum` and multiply to `product`:
//   shear J^(-5/3) (s - (sum + s)/3) + bulk (J - 1) = -pressure,   J = sqrt(product s),   s the stretch squared
// The left side rises with s: Newton's steps, kept between the ends of a bisection.
double normal_stretch_squared(const Elastic& matter, double sum, double product, double pressure) {
  constexpr int kSteps = 40;
  constexpr double kClose = 1e-12;
  const double shear = matter.shear(), bulk = matter.bulk();
  double s = 1.0 / product, low = 1e-3 * s, high = 1e3 * s;  // as if nothing could be compressed
  for (int i = 0; i < kSteps; ++i) {
    const double J = std::sqrt(product * s), scaled = shear * std::pow(J, -5.0 / 3.0);
    const double off = scaled * (2.0 * s - sum) / 3.0 + bulk * (J - 1.0) + pressure;
    const double slope = scaled * (2.0 / 3.0 - 5.0 / 18.0 * (2.0 * s - sum) / s) + 0.5 * bulk * J / s;
    (off < 0.0 ? low : high) = s;
    const double next = s - off / slope;
    const double taken = next > low && next < high ? next : 0.5 * (low + high);
    const bool settled = std::abs(taken - s) <= kClose * s;
    s = taken;
    if (settled) break;
  }
  return s;
}

}  // namespace

double surface_von_mises(const Elastic& matter, const Eigen::Matrix2d& C, double pressure) {
  const double sum = C.trace(), product = C.determinant();
  if (!(product > 0.0 && sum > 0.0 && std::isfinite(sum))) return 0.0;
  const double apart = std::sqrt(std::max(0.0, 0.25 * sum * sum - product));
  const double s = normal_stretch_squared(matter, sum, product, pressure);
  const Vector3 squares(0.5 * sum + apart, 0.5 * sum - apart, s);
  const Vector3 deviator = squares.array() - squares.mean();
  return std::sqrt(1.5) * matter.shear() * std::pow(product * s, -5.0 / 6.0) * deviator.norm();
}

}  // namespace palpate::physics::deformable
