#include "palpate/device/camera_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace palpate::device {
namespace {

CameraModel lens() {
  CameraModel camera;
  camera.fx = 560.0, camera.fy = 561.5, camera.cx = 318.7, camera.cy = 242.1;
  camera.distortion = {-0.28, 0.09, 0.001, -0.0005, 0.0};
  return camera;
}

// 150 degrees from corner to corner.
CameraModel wide_lens() {
  CameraModel camera;
  camera.fx = 305.0, camera.fy = 304.2, camera.cx = 321.4, camera.cy = 238.0;
  camera.distortion = {0.021, -0.013, 0.004, -0.0009, 0.0};
  camera.kind = LensKind::fisheye;
  return camera;
}

// 120 degrees from corner to corner.
CameraModel rational_lens() {
  CameraModel camera;
  camera.fx = 420.0, camera.fy = 419.1, camera.cx = 317.4, camera.cy = 241.0;
  camera.distortion = {0.45, 0.05, 0.0006, -0.0004, 0.002, 0.78, 0.17, 0.011};
  camera.kind = LensKind::rational;
  return camera;
}

TEST(CameraModel, UndistortUndoesTheLensOverTheWholeImage) {
  for (const auto& camera : {lens(), wide_lens(), rational_lens()})
    for (int v = 0; v < 480; v += 20)
      for (int u = 0; u < 640; u += 20) {
        const auto ideal = camera.undistort_pixel(Pixel(u, v));
        ASSERT_TRUE(ideal.has_value());
        const Vector3 ray((ideal->x() - camera.cx) / camera.fx, (ideal->y() - camera.cy) / camera.fy, 1.0);
        EXPECT_NEAR((camera.project(0.7 * ray) - Pixel(u, v)).norm(), 0.0, 1e-9);
        EXPECT_NEAR(*angle_from_axis(camera, Pixel(u, v)), std::atan(ray.head<2>().norm()), 1e-12);
      }
}

TEST(CameraModel, AWideLensSeesByTheAngleFromItsAxis) {
  CameraModel camera = wide_lens();
  camera.fx = camera.fy = 100.0, camera.cx = camera.cy = 0.0;
  camera.distortion = {0.1, 0.01, -0.02, 0.003, 0.0};
  const double t = 1.2;  // in a direction of 3 to 4
  const double seen =
      t + 0.1 * t * t * t + 0.01 * std::pow(t, 5) - 0.02 * std::pow(t, 7) + 0.003 * std::pow(t, 9);
  const Pixel pixel = camera.project({0.5 * 0.6 * std::tan(t), 0.5 * 0.8 * std::tan(t), 0.5});
  EXPECT_NEAR(pixel.x(), 60.0 * seen, 1e-10);
  EXPECT_NEAR(pixel.y(), 80.0 * seen, 1e-10);
  EXPECT_EQ(camera.project({0.0, 0.0, 2.0}), Pixel(0.0, 0.0));
}

TEST(CameraModel, AWideLensIsNotFollowedBeyondEightyDegreesNorPastWhereItTurnsBack) {
  CameraModel camera = wide_lens();
  camera.cx = 0.0, camera.distortion = {};
  const auto at = [&](double degrees) { return camera.undistort({degrees * std::numbers::pi / 180.0, 0.0}); };
  EXPECT_TRUE(at(79.9));
  EXPECT_FALSE(at(80.1));
  EXPECT_NEAR(*angle_from_axis(camera, {305.0 * 1.7, camera.cy}), 1.7, 1e-12) << "beyond ninety degrees, too";
  camera.distortion = {-0.4, 0.0, 0.0, 0.0, 0.0};  // grows up to t = 0.913, where it sees 0.609
  EXPECT_TRUE(camera.undistort({0.6, 0.0}));
  EXPECT_FALSE(camera.undistort({0.62, 0.0}));
  EXPECT_FALSE(angle_from_axis(camera, {305.0 * 0.62, camera.cy}));
}

TEST(CameraModel, ARationalLensIsNotFollowedPastItsPoleNorPastWhereItTurnsBack) {
  CameraModel camera = rational_lens();
  camera.distortion = {0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0};  // sees r / (1 + r^2): 0.5 at most, at r = 1
  EXPECT_NEAR(camera.undistort({0.4, 0.0})->x(), 0.5, 1e-12);
  EXPECT_FALSE(camera.undistort({0.51, 0.0}));
  camera.distortion[5] = -1.0;  // r / (1 - r^2): any distance is seen before the pole at r = 1
  EXPECT_NEAR(camera.undistort({1.5, 0.0})->x(), (std::sqrt(10.0) - 1.0) / 3.0, 1e-12);
  const auto left = camera.undistort({-40.0, 0.0});
  if (left) EXPECT_LT(left->norm(), 1.0) << "beyond the pole a place on the other side is seen there";
}

TEST(CameraModel, LensesAreCalledByTheirWords) {
  for (const auto kind : {LensKind::brown, LensKind::fisheye, LensKind::rational})
    EXPECT_EQ(lens_kind(lens_word(kind)), kind);
  EXPECT_FALSE(lens_kind("prism"));
  EXPECT_EQ(rational_lens().coefficients().size(), 8u);
  EXPECT_EQ(lens().coefficients().size(), 5u);
  EXPECT_EQ(wide_lens().coefficients().size(), 4u);
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
  for (const auto& camera : {lens(), wide_lens(), rational_lens()})
    for (const Vector3& p : {Vector3(0.35, -0.25, 0.8), Vector3(1e-9, 0.0, 0.8)}) {
      const auto J = lens_jacobian(camera, p);
      for (Eigen::Index i = 0; i < kLensParameters; ++i) {
        const LensParameters h = 1e-4 * LensParameters::Unit(i);
        const Pixel numeric =
            (changed_lens(camera, h).project(p) - changed_lens(camera, -h).project(p)) / 2e-4;
        EXPECT_NEAR((J.col(i) - numeric).norm(), 0.0, 1e-8 * (1.0 + J.col(i).norm())) << i;
      }
    }
}

TEST(CameraModel, JacobianThroughTheLensAgreesWithFiniteDifferences) {
  // Near a corner of the image, where the lens bends most; on the axis of a wide one.
  for (const auto& [camera, p] :
       {std::pair{lens(), Vector3(0.35, -0.25, 0.8)}, std::pair{wide_lens(), Vector3(0.5, -0.4, 0.2)},
        std::pair{wide_lens(), Vector3(0.0, 0.0, 0.8)},
        std::pair{rational_lens(), Vector3(0.5, -0.4, 0.4)}}) {
    Eigen::Matrix<double, 2, 3> J;
    EXPECT_NEAR((project(camera, p, J) - camera.project(p)).norm(), 0.0, 1e-12);
    for (int i = 0; i < 3; ++i) {
      const Vector3 h = 1e-6 * Vector3::Unit(i);
      const Pixel numeric = (camera.project(p + h) - camera.project(p - h)) / 2e-6;
      EXPECT_NEAR((J.col(i) - numeric).norm(), 0.0,
                  1e-5);  // J is some 700 px/m, the difference loses 1e-9 of it
    }
  }
}

}  // namespace
}  // namespace palpate::device
