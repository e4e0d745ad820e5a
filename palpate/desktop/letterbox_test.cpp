#include "palpate/desktop/letterbox.h"

#include <gtest/gtest.h>

namespace palpate::desktop {
namespace {

TEST(Letterbox, FillsAWindowOfThePicturesShape) {
  EXPECT_EQ(letterbox({640, 480}, {640, 480}), (Box{0, 0, 640, 480}));
  EXPECT_EQ(letterbox({640, 480}, {1280, 960}), (Box{0, 0, 1280, 960}));
}

TEST(Letterbox, LeavesBarsAtTheSidesOfAWideWindowAndAboveInATallOne) {
  EXPECT_EQ(letterbox({640, 480}, {1920, 1080}), (Box{240, 0, 1440, 1080}));
  EXPECT_EQ(letterbox({640, 480}, {480, 960}), (Box{0, 300, 480, 360}));
}

// The largest box that fits and keeps the shape, found by trying every width.
TEST(Letterbox, IsTheLargestThatFits) {
  for (const Size window : {Size{301, 777}, Size{1000, 333}, Size{64, 48}, Size{7, 1000}}) {
    const Size picture{640, 480};
    int best = 0;
    for (int width = 1; width <= window.width; ++width)
      if (width * picture.height <= window.height * picture.width) best = width;
    const Box box = letterbox(picture, window);
    EXPECT_LE(std::abs(box.width - best), 1);
    EXPECT_LE(box.x + box.width, window.width);
    EXPECT_LE(box.y + box.height, window.height);
    // In the middle to a pixel.
    EXPECT_LE(std::abs(window.width - box.width - 2 * box.x), 1);
    EXPECT_LE(std::abs(window.height - box.height - 2 * box.y), 1);
  }
}

TEST(Letterbox, IsEmptyWhereThereIsNothingToShowOrNowhere) {
  EXPECT_EQ(letterbox({0, 0}, {640, 480}), Box{});
  EXPECT_EQ(letterbox({640, 480}, {0, 480}), Box{});  // a window made an icon of
}

TEST(Letterbox, MapsThePicturesCornersAndMiddleToItsPixels) {
  const Size picture{640, 480};
  const Box box = letterbox(picture, {1920, 1080});
  const device::Pixel corner = picture_pixel(box, picture, {240.0, 0.0});
  EXPECT_DOUBLE_EQ(corner.x(), -0.5);  // the corner of the first pixel, whose centre is (0, 0)
  EXPECT_DOUBLE_EQ(corner.y(), -0.5);
  const device::Pixel middle = picture_pixel(box, picture, {960.0, 540.0});
  EXPECT_DOUBLE_EQ(middle.x(), 319.5);
  EXPECT_DOUBLE_EQ(middle.y(), 239.5);
  EXPECT_LT(picture_pixel(box, picture, {100.0, 540.0}).x(), -0.5);  // on the bar
}

// Two pictures of 640x480 in a window of 1000x400: 1000x375, each eye's 500 wide.
TEST(Letterbox, OfTwoEyesSideBySideEachHalfMapsToItsOwnEyesPicture) {
  const Size both{1280, 480};
  const Box box = letterbox(both, {1000, 400});
  for (const auto& [x, u] : {std::pair{0.0, -0.5}, std::pair{250.0, 319.5}, std::pair{499.0, 638.22},
                             std::pair{500.0, -0.5}, std::pair{750.0, 319.5}, std::pair{999.0, 638.22}}) {
    const device::Pixel pixel = eye_pixel(picture_pixel(box, both, {x, 199.5}), both, 2);
    EXPECT_NEAR(pixel.x(), u, 1e-9) << x;
    EXPECT_NEAR(pixel.y(), 239.5, 1e-9) << x;
  }
  // Beside the picture it is beside the nearer eye's.
  EXPECT_DOUBLE_EQ(eye_pixel({-10.0, 5.0}, both, 2).x(), -10.0);
  EXPECT_DOUBLE_EQ(eye_pixel({1290.0, 5.0}, both, 2).x(), 650.0);
  // One eye's picture is the whole.
  EXPECT_DOUBLE_EQ(eye_pixel({900.0, 5.0}, both, 1).x(), 900.0);
}

}  // namespace
}  // namespace palpate::desktop
