#include "palpate/device/camera_model.h"

#include <gtest/gtest.h>

namespace palpate::device {
namespace {

CameraModel lens() {
  CameraModel camera;
  camera.fx = 560.0, camera.fy = 561.5, camera.cx = 318.7, camera.cy = 242.1;
  camera.distortion = {-0.28, 0.09, 0.001, -0.0005, 0.0};
  return camera;
}

TEST(CameraModel, UndistortUndoesTheLensOverTheWholeImage) {
  const auto camera = lens();
  for (int v = 0; v < 480; v += 20)
    for (int u = 0; u < 640; u += 20) {
      const auto ideal = camera.undistort_pixel(Pixel(u, v));
      ASSERT_TRUE(ideal.has_value());
      const Vector3 ray((ideal->x() - camera.cx) / camera.fx, (ideal->y() - camera.cy) / camera.fy, 1.0);
      EXPECT_NEAR((camera.project(0.7 * ray) - Pixel(u, v)).norm(), 0.0, 1e-9);
    }
}

TEST(CameraModel, AgreesWithAHandComputedPoint) {
  CameraModel camera;
  camera.fx = camera.fy = 100.0, camera.cx = camera.cy = 0.0;
  camera.distortion = {0.1, 0, 0.01, 0.02, 0};
  // x = 0.5, y = 0.25: r2 = 0.3125, radial = 1.03125
  EXPECT_NEAR(camera.project({1.0, 0.5, 2.0}).x(),
              100.0 * (0.515625 + 2 * 0.01 * 0.125 + 0.02 * (0.3125 + 0.5)), 1e-12);
  EXPECT_NEAR(camera.project({1.0, 0.5, 2.0}).y(),
              100.0 * (0.2578125 + 0.01 * (0.3125 + 0.125) + 2 * 0.02 * 0.125), 1e-12);
}

TEST(CameraModel, JacobianAgreesWithFiniteDifferences) {
  const auto camera = lens();
  const Vector3 p(0.2, -0.1, 0.8);
  const auto J = projection_jacobian(camera, p);
  for (int i = 0; i < 3; ++i) {
    const Vector3 h = 1e-6 * Vector3::Unit(i);
    const Pixel numeric = (camera.project_undistorted(p + h) - camera.project_undistorted(p - h)) / 2e-6;
    EXPECT_NEAR((J.col(i) - numeric).norm(), 0.0, 1e-5);
  }
}

TEST(CameraModel, LensJacobianAgreesWithFiniteDifferences) {
  const auto camera = lens();
  const Vector3 p(0.35, -0.25, 0.8);
  const auto J = lens_jacobian(camera, p);
  for (Eigen::Index i = 0; i < kLensParameters; ++i) {
    const LensParameters h = 1e-4 * LensParameters::Unit(i);
    const Pixel numeric = (changed_lens(camera, h).project(p) - changed_lens(camera, -h).project(p)) / 2e-4;
    EXPECT_NEAR((J.col(i) - numeric).norm(), 0.0, 1e-8 * (1.0 + J.col(i).norm())) << i;
  }
}

TEST(CameraModel, JacobianThroughTheLensAgreesWithFiniteDifferences) {
  const auto camera = lens();
  const Vector3 p(0.35, -0.25, 0.8);  // near a corner of the image, where the lens bends most
  Eigen::Matrix<double, 2, 3> J;
  EXPECT_NEAR((project(camera, p, J) - camera.project(p)).norm(), 0.0, 1e-12);
  for (int i = 0; i < 3; ++i) {
    const Vector3 h = 1e-6 * Vector3::Unit(i);
    const Pixel numeric = (camera.project(p + h) - camera.project(p - h)) / 2e-6;
    EXPECT_NEAR((J.col(i) - numeric).norm(), 0.0,
                1e-5);  // J is some 700 px/m, the difference loses 1e-9 of it
  }
}

}  // namespace
}  // namespace palpate::device
