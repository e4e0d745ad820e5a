#include "palpate/calibration/session/picture_marker.h"

#include <gtest/gtest.h>

#include <vector>

namespace palpate::calibration::session {
namespace {

constexpr double kTrackerLate = 0.01, kCameraLate = 0.06;  // s, from the moment to the host
constexpr double kSpeed = 0.4;                             // m/s of the head, along x

// The head moves steadily; devices have clocks of their own. `seen`: by the tracker.
struct MovingHead {
  PictureMarker marker;
  double t = 0.0;  // host time
  long ms = 0;
  bool seen = true;
  int looks_every_ms = 1;
  std::vector<device::TrackerSample> tracked;  // since one looked

  void run(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i, ++ms) {
      t = 100.0 + 1e-3 * static_cast<double>(ms);
      for (auto& sample : tracked) sample.waited += std::chrono::milliseconds(1);
      if (ms % 10 == 0) {
        device::TrackerSample sample;
        sample.stamp = Instant<TrackerClock>::from_seconds(t - kTrackerLate - 42.0);
        sample.marker = device::MarkerId::camera_marker;
        sample.seen = seen;
        sample.translation = {kSpeed * (t - kTrackerLate), 0.0, 0.0};
        tracked.push_back(sample);
        sample.marker = device::MarkerId::pointer;  // of another one
        sample.translation = {7.0, 7.0, 7.0};
        tracked.push_back(sample);
      }
      if (ms % looks_every_ms != 0) continue;
      marker.watch(t, tracked);
      tracked.clear();
    }
  }
  SeenMarker picture() {
    device::CameraImage image;
    image.mid_exposure = Instant<CameraClock>::from_seconds(t - kCameraLate + 17.0);
    return marker.at(image, t, kCameraLate - kTrackerLate);
  }
  double where_it_was() const { return kSpeed * (t - kCameraLate); }
};

TEST(PictureMarker, TellsWhereTheMarkerWasAndNotWhereItIs) {
  MovingHead head;
  for (int i = 0; i < 30; ++i) {
    head.run(33);
    const SeenMarker seen = head.picture();
    if (i < 3) continue;  // clocks settle
    ASSERT_TRUE(seen.seen) << i;
    EXPECT_NEAR(seen.translation.x(), head.where_it_was(), 0.5e-3) << i;
    EXPECT_EQ(seen.translation.y(), 0.0);
  }
}

// Who looks for boards in between: never just when a sample has come.
TEST(PictureMarker, TellsItAsWellToOneWhoLooksRarely) {
  MovingHead head;
  head.looks_every_ms = 137;
  for (int i = 0; i < 30; ++i) {
    head.run(137);
    const SeenMarker seen = head.picture();
    if (i < 3) continue;
    ASSERT_TRUE(seen.seen) << i;
    EXPECT_NEAR(seen.translation.x(), head.where_it_was(), 0.5e-3) << i;
  }
}

TEST(PictureMarker, KnowsNothingOfAMarkerThatWasHidden) {
  MovingHead head;
  head.run(500);
  EXPECT_TRUE(head.picture().seen);
  head.seen = false;
  head.run(400);
  EXPECT_FALSE(head.picture().seen);
  head.seen = true;
  head.run(200);
  EXPECT_TRUE(head.picture().seen);
  EXPECT_FALSE(MovingHead().picture().seen);
}

}  // namespace
}  // namespace palpate::calibration::session
