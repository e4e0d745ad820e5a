#include "palpate/headset/picture_quad.h"

#include <gtest/gtest.h>

namespace palpate::headset {
namespace {

// A camera that is nothing like symmetrical.
device::CameraModel odd_camera() {
  device::CameraModel camera;
  camera.width = 800;
  camera.height = 500;
  camera.fx = 610.0;
  camera.fy = 590.0;
  camera.cx = 371.0;
  camera.cy = 268.0;
  return camera;
}

// Where a pixel of the picture stands on the panel: u from its left edge, v from its upper one.
Point<Panel> on_panel(const PictureQuad& quad, const device::CameraModel& camera, double u, double v) {
  return {Vector3((u + 0.5) / camera.width - 0.5, 0.5 - (v + 0.5) / camera.height, 0.0)
              .cwiseProduct(Vector3(quad.width, quad.height, 0.0))};
}

TEST(PictureQuad, EveryPixelLiesOnTheRayThatItWasSeenAlong) {
  const device::CameraModel camera = odd_camera();
  const double depth = 0.73;
  const PictureQuad quad = picture_quad(camera, depth);
  for (const double u : {-0.5, 0.0, 399.5, 640.25, 799.5})
    for (const double v : {-0.5, 0.0, 268.0, 499.5}) {
      const Point<CameraOptical> p = quad.X_camera_panel * on_panel(quad, camera, u, v);
      EXPECT_NEAR(p.m.z(), depth, 1e-12);
      const device::Pixel pixel = camera.project_undistorted(p.m);
      EXPECT_NEAR(pixel.x(), u, 1e-9) << u << " " << v;
      EXPECT_NEAR(pixel.y(), v, 1e-9) << u << " " << v;
    }
}

TEST(PictureQuad, ShowsItsFrontToTheCamera) {
  const PictureQuad quad = picture_quad(odd_camera(), 0.6);
  const Direction<CameraOptical> front = quad.X_camera_panel * Direction<Panel>{Vector3::UnitZ()};
  EXPECT_LT(front.v.z(), -0.999);
}

TEST(PictureQuad, ACameraBetweenTheEyesLooksWhereTheHeadDoes) {
  const Pose<View, CameraOptical> X = camera_between_the_eyes();
  EXPECT_TRUE((X * Direction<CameraOptical>{Vector3::UnitZ()}).v.isApprox(-Vector3::UnitZ(), 1e-15));
  EXPECT_TRUE((X * Direction<CameraOptical>{Vector3::UnitY()}).v.isApprox(-Vector3::UnitY(), 1e-15));
  EXPECT_TRUE((X * Direction<CameraOptical>{Vector3::UnitX()}).v.isApprox(Vector3::UnitX(), 1e-15));
}

}  // namespace
}  // namespace palpate::headset
