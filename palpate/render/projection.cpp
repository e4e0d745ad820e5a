#include "palpate/render/projection.h"

namespace palpate::render {

Matrix4f projection_matrix(const device::CameraModel& camera, double near_m, double far_m) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m(0, 0) = 2.0 * camera.fx / camera.width;
  m(0, 2) = 2.0 * (camera.cx + 0.5) / camera.width - 1.0;
  m(1, 1) = 2.0 * camera.fy / camera.height;
  m(1, 2) = 2.0 * (camera.cy + 0.5) / camera.height - 1.0;
  m(2, 2) = (far_m + near_m) / (far_m - near_m);
  m(2, 3) = -2.0 * far_m * near_m / (far_m - near_m);
  m(3, 2) = 1.0;
  return m.cast<float>();
}

}  // namespace palpate::render
