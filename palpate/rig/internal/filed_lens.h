// The covariance of a lens in memory, where each kind has the same parameters (device::kLensParameters), and in a rig file, where
// a lens of five coefficients and less keeps the nine that files had from the beginning. Private to the module.
#pragma once

#include <Eigen/Core>

#include "palpate/device/camera_model.h"

namespace palpate::rig {

constexpr std::size_t filed_coefficients(device::LensKind kind) {
  return kind == device::LensKind::rational ? device::kMostCoefficients : 5;
}
constexpr Eigen::Index filed_lens_parameters(device::LensKind kind) {
  return 4 + static_cast<Eigen::Index>(filed_coefficients(kind));
}

// From a file; the lens comes first, what follows is kept.
inline Eigen::MatrixXd with_all_parameters(const Eigen::MatrixXd& filed, device::LensKind kind) {
  const Eigen::Index lens = filed_lens_parameters(kind), more = device::kLensParameters - lens;
  const Eigen::Index rest = filed.rows() - lens, size = filed.rows() + more;
  if (more == 0 || rest < 0) return filed;
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(size, size);
  all.topLeftCorner(lens, lens) = filed.topLeftCorner(lens, lens);
  all.topRightCorner(lens, rest) = filed.topRightCorner(lens, rest);
  all.bottomLeftCorner(rest, lens) = filed.bottomLeftCorner(rest, lens);
  all.bottomRightCorner(rest, rest) = filed.bottomRightCorner(rest, rest);
  return all;
}

// Into a file: the inverse of the above.
inline Eigen::MatrixXd filed_covariance(const Eigen::MatrixXd& all, device::LensKind kind) {
  const Eigen::Index lens = filed_lens_parameters(kind), more = device::kLensParameters - lens;
  const Eigen::Index rest = all.rows() - device::kLensParameters;
  if (more == 0 || rest < 0) return all;
  Eigen::MatrixXd filed(lens + rest, lens + rest);
  filed << all.topLeftCorner(lens, lens), all.topRightCorner(lens, rest), all.bottomLeftCorner(rest, lens),
      all.bottomRightCorner(rest, rest);
  return filed;
}

}  // namespace palpate::rig
