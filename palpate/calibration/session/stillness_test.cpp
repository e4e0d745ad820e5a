#include "palpate/calibration/session/stillness.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/random.h"

namespace palpate::calibration::session {
namespace {

device::TrackerSample at(double t, const Vector3& place, bool seen = true) {
  device::TrackerSample sample;
  sample.stamp = {seconds(t)};
  sample.marker = device::MarkerId::pointer;
  sample.seen = seen;
  sample.translation = place;
  return sample;
}

// 100 Hz for `seconds_long`, moved by `velocity`.
double feed(Stillness& still, double from, double seconds_long, const Vector3& place,
            const Vector3& velocity = Vector3::Zero()) {
  double t = from;
  for (; t < from + seconds_long; t += 0.01) still.add(at(t, place + velocity * (t - from)));
  return t;
}

TEST(Stillness, IsWhatStaysInItsPlaceForTheWholeTime) {
  Stillness still(device::MarkerId::pointer);
  EXPECT_FALSE(still.seen() || still.still());
  double t = feed(still, 0.0, 0.3, Vector3(1, 2, 3));
  EXPECT_TRUE(still.seen());
  EXPECT_FALSE(still.still()) << "not long enough";
  t = feed(still, t, 0.2, Vector3(1, 2, 3));
  EXPECT_TRUE(still.still());
  t = feed(still, t, 0.5, Vector3(1, 2, 3), Vector3(0.005, 0, 0));
  EXPECT_FALSE(still.still()) << "5 mm/s is a move";
}

TEST(Stillness, ATremblingHandIsStillAndAHiddenMarkerIsNot) {
  Stillness still(device::MarkerId::pointer);
  Random random(1, "stillness");
  double t = 0.0;
  for (int i = 0; i < 60; ++i, t += 0.01)
    still.add(at(t, Vector3(random.normal(8e-5), random.normal(8e-5), random.normal(8e-5))));
  EXPECT_TRUE(still.still());
  still.add(at(t, Vector3::Zero(), false));
  EXPECT_FALSE(still.seen() || still.still());
  t = feed(still, t + 0.01, 0.3, Vector3::Zero());
  EXPECT_FALSE(still.still()) << "what was before it was hidden does not count";
}

// A server that says nothing of a marker it does not see; others it does see.
TEST(Stillness, OfWhatNothingIsHeardIsNotSeen) {
  Stillness still(device::MarkerId::pointer);
  double t = 0.0;
  for (; t < 1.0; t += 0.01) {
    const auto sample = at(t, Vector3(1, 2, 3));
    still.watch(5.0 + t, {&sample, 1});
  }
  EXPECT_TRUE(still.still());
  device::TrackerSample other = at(t, Vector3::Zero());
  other.marker = device::MarkerId::tip_marker;
  still.watch(5.0 + t + 0.3, {&other, 1});
  EXPECT_TRUE(still.seen()) << "a tracker may stutter";
  still.watch(5.0 + t + 0.6, {&other, 1});
  EXPECT_FALSE(still.seen() || still.still() || still.newest());
}

// The far end of a tracker's volume: single poses lie up to 7 mrad from one another, and the marker rests.
TEST(Stillness, ANoisyTrackerDoesNotHideThatAMarkerRestsNorThatItTurns) {
  Random random(2, "stillness");
  int rested = 0;
  bool moved = true;
  for (int hold = 0; hold < 50; ++hold) {
    Stillness resting(device::MarkerId::pointer), turning(device::MarkerId::pointer);
    for (int i = 0; i < 60; ++i) {
      auto sample = at(0.01 * i, Vector3(random.normal(1e-4), random.normal(1e-4), random.normal(1e-4)));
      const Vector3 noise(random.normal(1.5e-3), random.normal(1.5e-3), random.normal(1.5e-3));
      sample.rotation = so3_exp(noise);
      resting.add(sample);
      sample.rotation = so3_exp(noise + Vector3(0.0, 0.0, 0.0003 * i));  // 1.7 degrees a second
      turning.add(sample);
    }
    rested += resting.still();
    moved = moved && !turning.still();
  }
  EXPECT_EQ(rested, 50);
  EXPECT_TRUE(moved);
}

TEST(Stillness, ATurnInPlaceIsAMove) {
  Stillness still(device::MarkerId::pointer);
  for (int i = 0; i < 100; ++i) {
    auto sample = at(0.01 * i, Vector3::Zero());
    sample.rotation = so3_exp(Vector3(0.0, 0.0, 0.0005 * i));  // 3 degrees a second
    still.add(sample);
  }
  EXPECT_FALSE(still.still());
}

TEST(Stillness, OfOtherMarkersNothingIsKeptAndAClockBegunAnewBeginsAnew) {
  Stillness still(device::MarkerId::tip_marker);
  feed(still, 0.0, 1.0, Vector3::Zero());
  EXPECT_FALSE(still.seen());
  Stillness other(device::MarkerId::pointer);
  feed(other, 100.0, 1.0, Vector3::Zero());
  EXPECT_TRUE(other.still());
  other.add(at(0.0, Vector3::Zero()));
  EXPECT_FALSE(other.still());
  feed(other, 0.01, 1.0, Vector3::Zero());
  EXPECT_TRUE(other.still());
}

TEST(Stillness, APoseIsTakenOnce) {
  Stillness still(device::MarkerId::pointer);
  double t = feed(still, 0.0, 0.5, Vector3::Zero());
  EXPECT_TRUE(still.moved()) << "nothing was taken yet";
  still.take();
  EXPECT_FALSE(still.moved());
  t = feed(still, t, 0.5, Vector3(0.004, 0, 0));
  EXPECT_FALSE(still.moved()) << "4 mm";
  feed(still, t, 0.5, Vector3(0.02, 0, 0));
  EXPECT_TRUE(still.moved());
}

}  // namespace
}  // namespace palpate::calibration::session
