#include "palpate/calibration/stated_overlay.h"

#include <cmath>

namespace palpate {

std::optional<double> stated_overlay_px(const CameraModel& camera,
                                        const Pose<World, CameraOptical>& X_world_camera,
                                        const Matrix6& covariance, std::span<const Vector3> points) {
  constexpr double kNearestPoint = 0.01;  // m
  const Matrix3 to_camera = X_world_camera.matrix().transpose();
  double sum = 0.0;
  int count = 0;
  for (const Vector3& point : points) {
    const Vector3 arm = point - X_world_camera.translation, p = to_camera * arm;
    if (p.z() < kNearestPoint) continue;
    const Pixel at = camera.project_undistorted(p);
    if (at.x() < -0.5 || at.y() < -0.5 || at.x() > camera.width - 0.5 || at.y() > camera.height - 0.5)
      continue;
    const Eigen::Matrix<double, 2, 3> from_world = projection_jacobian(camera, p) * to_camera;
    Eigen::Matrix<double, 2, 6> J;
    J << from_world * hat(arm), -from_world;
    sum += (J * covariance * J.transpose()).trace();
    ++count;
  }
  if (count == 0 || !(sum >= 0.0)) return std::nullopt;
  return std::sqrt(sum / count);
}

}  // namespace palpate
