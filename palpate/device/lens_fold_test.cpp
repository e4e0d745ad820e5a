#include "palpate/device/lens_fold.h"

#include <gtest/gtest.h>

namespace palpate::device {
namespace {

TEST(LensFold, UsualLensesDoNotFoldInside) {
  CameraModel lens;
  EXPECT_FALSE(folds_inside(lens));
  lens.distortion = {-0.28, 0.09, 0.001, -0.0005, 0.0};
  EXPECT_FALSE(folds_inside(lens));
}

TEST(LensFold, AStrongBarrelFoldsBeforeTheCorners) {
  CameraModel lens;
  lens.distortion = {-0.6, 0.0, 0.0, 0.0, 0.0};
  EXPECT_TRUE(folds_inside(lens));
  // Its corners have a solution on the other side of the centre, where the model has turned twice.
  lens.distortion = {-0.9, 0.0, 0.0, 0.0, 0.0};
  EXPECT_FALSE(lens.undistort_pixel({0.0, 0.0}));
  EXPECT_TRUE(folds_inside(lens));
}

}  // namespace
}  // namespace palpate::device
