// Smooth scalar fields over a box of space: uniform tricubic B-splines through values on a lattice.
//
// A spline goes through its values at the lattice's points, has continuous second derivatives, and its gradient
// is the exact one of what value() returns, which makes a force of it conservative. Its error falls with the
// fourth power of the spacing. At the lattice's ends its second derivative is zero (natural spline), so that
// linear fields are kept exactly.
//
// Several fields over one lattice share their weights; coefficients lie side by side as floats, which halves
// the memory the tick walks through, and are summed in double. Metres; fields in any unit. Const, any thread, no
// allocation after construction; sample() takes the same time everywhere.
// Source: Unser, Aldroubi, Eden 1991, "Fast B-spline transforms", IEEE Trans. PAMI 13 (here with natural ends,
// by the recursion of a tridiagonal system).
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "palpate/math/so3.h"

namespace palpate::physics::tissue {

struct Lattice {
  Vector3 origin = Vector3::Zero();  // the first point
  double spacing = 0.0;              // m, the same along all axes
  std::array<int, 3> count{};        // points along x, y, z; at least 4 each

  std::size_t size() const {
    return static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(count[1]) *
           static_cast<std::size_t>(count[2]);
  }
  // x runs fastest.
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(count[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(count[0]) +
           static_cast<std::size_t>(x);
  }
  Vector3 at(int x, int y, int z) const { return origin + spacing * Vector3(x, y, z); }
  // Whether splines can be sampled at p: one cell from the ends. Not for what is no number.
  bool covers(const Vector3& p) const {
    for (Eigen::Index i = 0; i < 3; ++i) {
      const double u = (p[i] - origin[i]) / spacing;
      if (!(u >= 1.0 && u < count[static_cast<std::size_t>(i)] - 2)) return false;
    }
    return true;
  }
};

// Throws std::invalid_argument for a lattice that cannot carry splines: spacing, counts or origin.
void check_lattice(const Lattice& lattice);

// Turns values at the lattice's points into the coefficients of the spline through them, in place. Throws
// std::invalid_argument where there are not as many as points.
void spline_coefficients(const Lattice& lattice, std::span<double> values);

struct FieldSample {
  double value = 0.0;
  Vector3 gradient = Vector3::Zero();  // per metre
};

// The four weights of a cubic B-spline at the place `t` in 0 ... 1 of a cell, and their derivatives.
struct CubicWeights {
  explicit CubicWeights(double t) {
    const double s = 1.0 - t, tt = t * t, ss = s * s;
    w = {ss * s / 6.0, (4.0 - 6.0 * tt + 3.0 * tt * t) / 6.0, (4.0 - 6.0 * ss + 3.0 * ss * s) / 6.0,
         tt * t / 6.0};
    d = {-0.5 * ss, -2.0 * t + 1.5 * tt, 2.0 * s - 1.5 * ss, 0.5 * tt};
  }
  std::array<double, 4> w, d;
};

template <std::size_t N>
class SplineFields {
 public:
  SplineFields() = default;
  // `coefficients`: for each point of the lattice those of the N fields. Throws std::invalid_argument where
  // there are not as many, or some are no numbers.
  SplineFields(const Lattice& lattice, std::vector<float> coefficients);
  // Of values at the lattice's points, a vector for each field.
  static SplineFields through(const Lattice& lattice, std::array<std::vector<double>, N> values);

  const Lattice& lattice() const { return lattice_; }
  const std::vector<float>& coefficients() const { return coefficients_; }

  // Where lattice().covers(p).
  std::array<FieldSample, N> sample(const Vector3& p) const;

 private:
  Lattice lattice_;
  std::vector<float> coefficients_;
};

template <std::size_t N>
std::array<FieldSample, N> SplineFields<N>::sample(const Vector3& p) const {
  const Vector3 u = (p - lattice_.origin) / lattice_.spacing;
  const auto x = static_cast<int>(u.x()), y = static_cast<int>(u.y()), z = static_cast<int>(u.z());
  const CubicWeights wx(u.x() - x), wy(u.y() - y), wz(u.z() - z);
  std::array<std::array<double, 4>, N> sum{};  // value, and derivatives along x, y, z
  for (int k = 0; k < 4; ++k) {
    const auto kk = static_cast<std::size_t>(k);
    for (int j = 0; j < 4; ++j) {
      const auto jj = static_cast<std::size_t>(j);
      const float* row = &coefficients_[N * lattice_.index(x - 1, y - 1 + j, z - 1 + k)];
      const double value = wy.w[jj] * wz.w[kk], along_y = wy.d[jj] * wz.w[kk], along_z = wy.w[jj] * wz.d[kk];
      for (std::size_t n = 0; n < N; ++n) {
        double a = 0.0, b = 0.0;
        for (std::size_t i = 0; i < 4; ++i) {
          const auto c = static_cast<double>(row[N * i + n]);
          a += wx.w[i] * c;
          b += wx.d[i] * c;
        }
        sum[n][0] += value * a;
        sum[n][1] += value * b;
        sum[n][2] += along_y * a;
        sum[n][3] += along_z * a;
      }
    }
  }
  std::array<FieldSample, N> samples;
  for (std::size_t n = 0; n < N; ++n)
    samples[n] = {sum[n][0], Vector3(sum[n][1], sum[n][2], sum[n][3]) / lattice_.spacing};
  return samples;
}

extern template class SplineFields<1>;
extern template class SplineFields<2>;

}  // namespace palpate::physics::tissue
