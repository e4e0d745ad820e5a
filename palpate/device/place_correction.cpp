#include "palpate/device/place_correction.h"

namespace palpate::device {
namespace {

constexpr int kStrains = 6;
// The axes of a strain, and of a product.
constexpr std::array<std::array<int, 2>, 6> kPairs{{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};

}  // namespace

PlaceCorrection::Basis PlaceCorrection::basis(const Vector3& stated) const {
  const Vector3 u = (stated - centre) / reach;
  Basis B = Basis::Zero();
  for (int k = 0; k < kStrains; ++k) {
    const auto [i, j] = kPairs[static_cast<std::size_t>(k)];
    B(i, k) = u[j];
    B(j, k) = u[i];
    for (int axis = 0; axis < 3; ++axis) B(axis, kStrains + 3 * k + axis) = u[i] * u[j];
  }
  return B;
}

Matrix3 PlaceCorrection::slope(const Vector3& stated) const {
  const Vector3 u = (stated - centre) / reach;
  Matrix3 D = Matrix3::Zero();
  for (int k = 0; k < kStrains; ++k) {
    const auto [i, j] = kPairs[static_cast<std::size_t>(k)];
    D(i, j) += terms[k];
    if (i != j) D(j, i) += terms[k];
    const Vector3 bend = terms.segment<3>(kStrains + 3 * k);
    D.col(i) += u[j] * bend;
    D.col(j) += u[i] * bend;
  }
  return D / reach;
}

const std::array<std::string, PlaceCorrection::kTerms>& PlaceCorrection::names() {
  static const auto list = [] {
    std::array<std::string, kTerms> names;
    for (int k = 0; k < kStrains; ++k) {
      const auto [i, j] = kPairs[static_cast<std::size_t>(k)];
      const std::string pair{"xyz"[i], "xyz"[j]};
      names[static_cast<std::size_t>(k)] = "strain_" + pair;
      for (int axis = 0; axis < 3; ++axis)
        names[static_cast<std::size_t>(kStrains + 3 * k + axis)] = "bend_" + pair + "_" + "xyz"[axis];
    }
    return names;
  }();
  return list;
}

}  // namespace palpate::device
