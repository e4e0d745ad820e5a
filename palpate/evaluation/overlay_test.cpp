#include "palpate/evaluation/overlay.h"

#include <gtest/gtest.h>

#include "palpate/core/units.h"

namespace palpate::evaluation {
namespace {

CameraView view() {
  CameraView v;
  v.lens.fx = 560.0, v.lens.fy = 561.5, v.lens.cx = 318.7, v.lens.cy = 242.1;
  v.lens.distortion = {-0.28, 0.09, 0.001, -0.0005, 0.0};
  return v;  // looks along +z from the origin
}

TEST(Overlay, PerfectEstimatesHaveNoError) {
  const auto v = view();
  for (double x : {-0.3, 0.0, 0.25})
    for (double y : {-0.2, 0.1})
      EXPECT_NEAR(overlay_error(v, {x, y, 0.8}, v, {x, y, 0.8}).value(), 0.0, 1e-9);
}

TEST(Overlay, OneMillimetreAtSixtyCentimetresIsAboutOnePixel) {
  const auto v = view();
  EXPECT_NEAR(overlay_error(v, {0.001, 0, 0.6}, v, {0, 0, 0.6}).value(), 560.0 * 0.001 / 0.6, 0.02);
}

TEST(Overlay, ATurnedPoseShowsAsFocalLengthTimesAngle) {
  const auto truth = view();
  auto estimated = truth;
  const double angle = radians_from_degrees(0.1);
  estimated.X_world_camera.rotation = so3_exp({0, angle, 0});
  EXPECT_NEAR(overlay_error(estimated, {0, 0, 1}, truth, {0, 0, 1}).value(), 560.0 * angle, 0.01);
}

TEST(Overlay, PointsTheTrueCameraDoesNotSeeAreLeftOut) {
  const auto v = view();
  EXPECT_FALSE(overlay_error(v, {0, 0, -1}, v, {0, 0, -1}).has_value());
  EXPECT_FALSE(overlay_error(v, {1, 0, 1}, v, {1, 0, 1}).has_value());
  EXPECT_FALSE(overlay_error(v, {5, 5, 1}, v, {5, 5, 1}).has_value());
}

}  // namespace
}  // namespace palpate::evaluation
