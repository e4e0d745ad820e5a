#include "palpate/calibration/stated_overlay.h"

#include <gtest/gtest.h>

#include "palpate/core/random.h"

namespace palpate {
namespace {

const Pose<World, CameraOptical> kCamera{
    Quaternion(Eigen::AngleAxisd(2.6, Vector3(1.0, 0.1, -0.05).normalized())), Vector3(0.1, 0.6, 0.5)};

std::vector<Vector3> points_in_view(const CameraModel& camera) {
  std::vector<Vector3> points;
  for (const Vector3& seen : {Vector3(-0.2, -0.1, 0.7), Vector3(0.15, 0.1, 1.1), Vector3(0.0, 0.2, 0.6)})
    points.push_back((kCamera * Point<CameraOptical>{seen}).m);
  for (const auto& p : points)
    EXPECT_LT(camera.project_undistorted((kCamera.inverse() * Point<World>{p}).m).x(), 640);
  return points;
}

// Poses drawn from the covariance, and the points drawn with each.
TEST(StatedOverlay, IsWhatWrongPosesDrawnFromTheCovarianceGive) {
  const CameraModel camera;
  const auto points = points_in_view(camera);
  Random random(5, "test/stated-overlay");
  Matrix6 mix = Matrix6::Zero();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) mix(i, j) = 4e-4 * random.normal();
  const Matrix6 covariance = mix * mix.transpose();
  double sum = 0.0;
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    Vector6 unit;
    for (int k = 0; k < 6; ++k) unit[k] = random.normal();
    const Vector6 e = mix * unit;
    const Pose<World, CameraOptical> wrong{so3_exp(e.head<3>()) * kCamera.rotation,
                                           kCamera.translation + e.tail<3>()};
    for (const auto& p : points)
      sum += (camera.project_undistorted((wrong.inverse() * Point<World>{p}).m) -
              camera.project_undistorted((kCamera.inverse() * Point<World>{p}).m))
                 .squaredNorm();
  }
  const auto stated = stated_overlay_px(camera, kCamera, covariance, points);
  ASSERT_TRUE(stated);
  // 20000 draws of a few independent directions: 1 % standard deviation.
  EXPECT_NEAR(*stated / std::sqrt(sum / (kDraws * static_cast<double>(points.size()))), 1.0, 0.03);
}

TEST(StatedOverlay, IsFocalLengthTimesAngleForATurnOfTheHead) {
  CameraModel camera;
  Matrix6 covariance = Matrix6::Zero();
  covariance(0, 0) = 1e-6;  // a milliradian about x
  const Pose<World, CameraOptical> straight;
  const auto stated = stated_overlay_px(camera, straight, covariance, std::vector<Vector3>{{0.0, 0.0, 1.0}});
  ASSERT_TRUE(stated);
  EXPECT_NEAR(*stated, camera.fy * 1e-3, 1e-12);
}

TEST(StatedOverlay, KnowsNothingWhereNoPointIsInView) {
  const CameraModel camera;
  const Pose<World, CameraOptical> straight;
  EXPECT_FALSE(
      stated_overlay_px(camera, straight, Matrix6::Identity(), std::vector<Vector3>{{0, 0, -1}, {5, 0, 1}}));
  EXPECT_FALSE(stated_overlay_px(camera, straight, Matrix6::Identity(), {}));
}

}  // namespace
}  // namespace palpate
