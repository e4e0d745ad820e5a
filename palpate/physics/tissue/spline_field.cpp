#include "palpate/physics/tissue/spline_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace palpate::physics::tissue {
namespace {

constexpr int kMostPoints = 4096;  // along an axis: far more than any memory holds in three

// One line of values, `stride` apart, into coefficients c with (c[i-1] + 4 c[i] + c[i+1]) / 6 = value[i], and
// c = value at both ends. `share` is room for as many numbers.
void filter_line(double* line, std::size_t count, std::size_t stride, std::vector<double>& share) {
  const auto at = [&](std::size_t i) -> double& { return line[i * stride]; };
  share[0] = 0.0;
  for (std::size_t i = 1; i + 1 < count; ++i) {
    share[i] = 1.0 / (4.0 - share[i - 1]);
    at(i) = (6.0 * at(i) - at(i - 1)) * share[i];
  }
  for (std::size_t i = count - 2; i > 0; --i) at(i) -= share[i] * at(i + 1);
}

}  // namespace

void check_lattice(const Lattice& lattice) {
  if (!(lattice.spacing > 0.0 && std::isfinite(lattice.spacing) && lattice.origin.allFinite()))
    throw std::invalid_argument(
        fmt::format("spline lattice: spacing {} m and a finite origin are not given together; more than 0 is "
                    "expected",
                    lattice.spacing));
  for (const int n : lattice.count)
    if (n < 4 || n > kMostPoints)
      throw std::invalid_argument(
          fmt::format("spline lattice: {} points along an axis; 4 to {} are expected", n, kMostPoints));
}

void spline_coefficients(const Lattice& lattice, std::span<double> values) {
  check_lattice(lattice);
  if (values.size() != lattice.size())
    throw std::invalid_argument(
        fmt::format("spline lattice: {} values for {} points", values.size(), lattice.size()));
  const auto nx = static_cast<std::size_t>(lattice.count[0]), ny = static_cast<std::size_t>(lattice.count[1]),
             nz = static_cast<std::size_t>(lattice.count[2]);
  std::vector<double> share(std::max({nx, ny, nz}));
  for (std::size_t row = 0; row < ny * nz; ++row) filter_line(&values[row * nx], nx, 1, share);
  for (std::size_t z = 0; z < nz; ++z)
    for (std::size_t x = 0; x < nx; ++x) filter_line(&values[z * nx * ny + x], ny, nx, share);
  for (std::size_t place = 0; place < nx * ny; ++place) filter_line(&values[place], nz, nx * ny, share);
}

template <std::size_t N>
SplineFields<N>::SplineFields(const Lattice& lattice, std::vector<float> coefficients)
    : lattice_(lattice), coefficients_(std::move(coefficients)) {
  check_lattice(lattice_);
  if (coefficients_.size() != N * lattice_.size())
    throw std::invalid_argument(fmt::format("spline lattice: {} coefficients for {} fields of {} points",
                                            coefficients_.size(), N, lattice_.size()));
  if (!std::all_of(coefficients_.begin(), coefficients_.end(), [](float c) { return std::isfinite(c); }))
    throw std::invalid_argument("spline lattice: a coefficient is no number");
}

template <std::size_t N>
SplineFields<N> SplineFields<N>::through(const Lattice& lattice, std::array<std::vector<double>, N> values) {
  for (auto& field : values) spline_coefficients(lattice, field);
  std::vector<float> coefficients(N * lattice.size());
  for (std::size_t i = 0; i < lattice.size(); ++i)
    for (std::size_t n = 0; n < N; ++n) coefficients[N * i + n] = static_cast<float>(values[n][i]);
  return SplineFields(lattice, std::move(coefficients));
}

template class SplineFields<1>;
template class SplineFields<2>;

}  // namespace palpate::physics::tissue
