#include "palpate/vision/second_camera.h"

#include <stdexcept>

#include "palpate/math/linear_algebra.h"

namespace palpate::vision {

SecondCamera fit_second_camera(const Estimate<LandmarkRefinement>& own,
                               const std::vector<rig::Landmark>& kept,
                               const Eigen::MatrixXd& kept_covariance) {
  constexpr Eigen::Index lens = device::kLensParameters, camera = lens + 6;
  const auto places = 3 * static_cast<Eigen::Index>(kept.size());
  if (own.value.landmarks.size() != kept.size() || own.covariance.rows() != camera + places ||
      kept_covariance.rows() != camera + places || kept_covariance.cols() != camera + places)
    throw std::invalid_argument("second camera: other landmarks than the first camera's");
  const Eigen::MatrixXd S_cL = own.covariance.topRightCorner(camera, places);
  const Eigen::MatrixXd S_LL = own.covariance.bottomRightCorner(places, places);
  const Eigen::MatrixXd G = solve_symmetric_columns(S_LL, S_cL.transpose()).transpose();
  const Eigen::MatrixXd C_LL = kept_covariance.bottomRightCorner(places, places);

  Eigen::VectorXd by(places);
  for (std::size_t i = 0; i < kept.size(); ++i)
    by.segment<3>(3 * static_cast<Eigen::Index>(i)) = kept[i].place.m - own.value.landmarks[i].place.m;
  const Eigen::VectorXd step = G * by;

  SecondCamera second{own.value.camera, own.value.hand_eye,
                      Eigen::MatrixXd(camera + places, camera + places)};
  second.camera.model = device::changed_lens(second.camera.model, step.head<lens>());
  auto& X = second.hand_eye.X_marker_camera;
  X = {(so3_exp(step.segment<3>(lens)) * X.rotation).normalized(), X.translation + step.segment<3>(lens + 3)};

  second.covariance.topLeftCorner(camera, camera) =
      own.covariance.topLeftCorner(camera, camera) - G * S_cL.transpose() + G * C_LL * G.transpose();
  second.covariance.topRightCorner(camera, places) = G * C_LL;
  second.covariance.bottomLeftCorner(places, camera) = (G * C_LL).transpose();
  second.covariance.bottomRightCorner(places, places) = C_LL;
  second.covariance = (0.5 * (second.covariance + second.covariance.transpose())).eval();
  if (second.camera.covariance.size() > 0)
    second.camera.covariance = second.covariance.topLeftCorner<lens, lens>();
  second.hand_eye.covariance = second.covariance.block<6, 6>(lens, lens);
  return second;
}

}  // namespace palpate::vision
