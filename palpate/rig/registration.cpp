#include "palpate/rig/rig.h"

namespace palpate::rig {

Eigen::MatrixXd registration_covariance(const Rig& rig) {
  constexpr Eigen::Index lens = device::kLensParameters, places = lens + 6;
  const auto size = places + 3 * static_cast<Eigen::Index>(rig.landmarks.size());
  Eigen::MatrixXd own = Eigen::MatrixXd::Zero(size, size);
  if (rig.camera && rig.camera->covariance.rows() == lens)
    own.topLeftCorner<lens, lens>() = rig.camera->covariance;
  if (rig.hand_eye) own.block<6, 6>(lens, lens) = rig.hand_eye->covariance;
  Eigen::Index at = places;
  for (const auto& landmark : rig.landmarks) own.block<3, 3>(at, at) = landmark.covariance, at += 3;
  const Eigen::MatrixXd& joint = rig.registration_covariance;
  if (joint.rows() != size || joint.cols() != size) return own;
  constexpr double kRounding = 1e-9;  // of writing and reading
  const auto agrees = [&](Eigen::Index from, Eigen::Index n) {
    const Eigen::MatrixXd a = own.block(from, from, n, n), b = joint.block(from, from, n, n);
    return (a - b).cwiseAbs().maxCoeff() <= kRounding * b.cwiseAbs().maxCoeff();
  };
  bool same = agrees(0, lens) && agrees(lens, 6);
  for (at = places; at < size; at += 3) same = same && agrees(at, 3);
  return same ? joint : own;
}

}  // namespace palpate::rig
