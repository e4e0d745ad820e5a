#include "palpate/device/camera_preview.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace palpate::device {
namespace {

// A picture each time it is asked, numbered; one that is not looked at is not drawn.
class CountingCamera : public CameraDevice {
 public:
  std::optional<CameraImage> poll() override {
    CameraImage image;
    image.frame = ++frames;
    image.width = image.height = 1;
    image.rgb = {1, 2, 3};
    return image;
  }
  std::optional<CameraImage> poll_unseen() override {
    auto image = poll();
    image->rgb.clear();
    ++unseen;
    return image;
  }
  std::uint64_t frames = 0;
  int unseen = 0;
};

struct PreviewOfTwo {
  CountingCamera left, right;
  std::vector<std::pair<std::uint64_t, bool>> shown;
  CameraPreview preview{left, &right, 10.0, [this](const CameraImage& image, bool is_right) {
                          EXPECT_FALSE(image.rgb.empty());
                          shown.emplace_back(image.frame, is_right);
                        }};
  void runs(double from_s, double to_s) {
    for (int ms = static_cast<int>(1e3 * from_s); ms < static_cast<int>(1e3 * to_s); ++ms)
      preview.refresh(1e-3 * ms);
  }
};

TEST(CameraPreview, ShowsTheLeftCameraAtItsRateWhileNobodyPolls) {
  PreviewOfTwo two;
  two.runs(0.0, 1.0);
  EXPECT_NEAR(static_cast<double>(two.shown.size()), 10.0, 1.0);
  EXPECT_EQ(two.left.frames, two.shown.size());
  EXPECT_EQ(two.right.frames, 0u);
}

TEST(CameraPreview, LosesNoPictureOfWhoeverWorksWithTheCamera) {
  PreviewOfTwo two;
  two.runs(0.0, 0.3);
  static_cast<void>(two.preview.camera().poll_unseen());  // pictures from before, as a procedure begins
  two.shown.clear();
  std::uint64_t last = two.left.frames;
  for (int ms = 300; ms < 1300; ++ms) {
    two.preview.refresh(1e-3 * ms);
    const auto image = two.preview.camera().poll();
    ASSERT_TRUE(image);
    EXPECT_EQ(image->frame, ++last);
    EXPECT_FALSE(image->rgb.empty());
  }
  EXPECT_NEAR(static_cast<double>(two.shown.size()), 10.0, 1.0);
}

TEST(CameraPreview, LooksAtFewOfThePicturesThatNobodyElseLooksAt) {
  PreviewOfTwo two;
  for (int ms = 0; ms < 1000; ++ms) {
    two.preview.refresh(1e-3 * ms);
    const auto image = two.preview.right()->poll_unseen();
    ASSERT_TRUE(image);
    EXPECT_TRUE(image->rgb.empty());
  }
  EXPECT_NEAR(two.right.unseen, 990, 2);
  // The left one is left alone meanwhile, but for the first millisecond in which nobody had polled yet.
  EXPECT_LE(two.left.frames, 1u);
  ASSERT_FALSE(two.shown.empty());
  EXPECT_TRUE(two.shown.back().second);
}

TEST(CameraPreview, ShowsTheLeftCameraAgainSoonAfterTheLastPoll) {
  PreviewOfTwo two;
  two.preview.refresh(0.0);
  static_cast<void>(two.preview.right()->poll());
  two.shown.clear();
  two.runs(0.0, 0.45);
  EXPECT_TRUE(two.shown.empty());
  two.runs(0.45, 0.7);
  ASSERT_FALSE(two.shown.empty());
  EXPECT_FALSE(two.shown.back().second);
}

TEST(CameraPreview, HasNoRightCameraWhereThereIsNone) {
  CountingCamera camera;
  CameraPreview preview(camera, nullptr, 10.0, [](const CameraImage&, bool) {});
  EXPECT_EQ(preview.right(), nullptr);
}

}  // namespace
}  // namespace palpate::device
