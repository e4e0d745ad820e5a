#include "palpate/calibration/session/holds.h"

#include <gtest/gtest.h>

#include "palpate/core/random.h"

namespace palpate::calibration::session {
namespace {

constexpr double kRate = 60.0, kNoise = 0.05e-3;
const Vector3 kTip(0.0, 0.0, -0.15);

// A pointer that is carried from place to place and held there.
struct Carried {
  Random random{11, "holds"};
  std::vector<TrackedPose> poses;
  std::vector<Vector3> places;

  void add(const Vector3& tip, const Vector3& turn, bool seen = true) {
    TrackedPose pose;
    pose.time_s = static_cast<double>(poses.size()) / kRate;
    pose.marker.stamp = Instant<TrackerClock>::from_seconds(100.0 + pose.time_s);
    pose.marker.marker = device::MarkerId::pointer;
    pose.marker.seen = seen;
    pose.marker.rotation = so3_exp(turn);
    pose.marker.translation = tip - pose.marker.rotation * kTip +
                              Vector3(random.normal(kNoise), random.normal(kNoise), random.normal(kNoise));
    pose.marker.covariance.bottomRightCorner<3, 3>() = kNoise * kNoise * Matrix3::Identity();
    pose.marker.systematic = 1e-8 * Matrix3::Identity();
    pose.joints = Vector3(pose.time_s, 0, 0);
    poses.push_back(pose);
  }
  void carry(const Vector3& from, const Vector3& to, double seconds_long) {
    const int steps = static_cast<int>(kRate * seconds_long);
    for (int i = 0; i < steps; ++i) {
      const double s = static_cast<double>(i) / steps, eased = s * s * (3.0 - 2.0 * s);
      add(from + eased * (to - from), Vector3(0.2 * eased, 0.0, 0.0));
    }
  }
  void hold(const Vector3& at, double seconds_long, int hidden_every = 0) {
    for (int i = 0; i < static_cast<int>(kRate * seconds_long); ++i)
      add(at, Vector3(0.2, 0.0, 0.0), hidden_every == 0 || i % hidden_every != hidden_every / 2);
    places.push_back(at);
  }
};

Carried four_places() {
  Carried made;
  Vector3 at(0.0, 0.3, 0.2);
  for (int i = 0; i < 4; ++i) {
    const Vector3 to(0.1 * i, -0.05 * i, 0.02 * i);
    made.carry(at, to, 1.0);
    made.hold(to, 1.5);
    at = to;
  }
  made.carry(at, Vector3(0, 0.3, 0.2), 1.0);
  return made;
}

TEST(Holds, EachPlaceIsFoundOnceAndWhereItIs) {
  const auto made = four_places();
  const auto holds = find_holds(made.poses);
  ASSERT_EQ(holds.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto touch = touch_of(holds[i], kTip);
    EXPECT_GT(touch.to_s - touch.from_s, 1.2);
    EXPECT_LT(touch.to_s - touch.from_s, 1.5) << "its ends are cut off";
    EXPECT_LT((touch.place - made.places[i]).norm(),
              4.0 * kNoise / std::sqrt(static_cast<double>(touch.frames)) + 0.01e-3);
    // White noise averages out, the systematic part does not; the scatter is that of single poses.
    EXPECT_NEAR(touch.covariance(0, 0), kNoise * kNoise / static_cast<double>(touch.frames) + 1e-8, 1e-13);
    EXPECT_NEAR(std::sqrt(touch.scatter(1, 1)), kNoise, 0.3 * kNoise);
  }
}

TEST(Holds, AMoveThatIsSlowIsNone) {
  Carried made;
  made.carry(Vector3(0, 0, 0), Vector3(0.05, 0, 0), 6.0);
  EXPECT_TRUE(find_holds(made.poses).empty());
}

TEST(Holds, AGlimpseThatIsLostDoesNotEndOne) {
  Carried made;
  made.carry(Vector3(0, 0.2, 0), Vector3(0, 0, 0), 1.0);
  made.hold(Vector3(0, 0, 0), 1.0);
  made.hold(Vector3(0, 0, 0), 2.0, 20);
  made.carry(Vector3(0, 0, 0), Vector3(0, 0.2, 0), 1.0);
  const auto holds = find_holds(made.poses);
  ASSERT_EQ(holds.size(), 1u);
  EXPECT_GT(holds[0].back().time_s - holds[0].front().time_s, 2.5);
  for (const auto& pose : holds[0]) EXPECT_TRUE(pose.marker.seen);
}

TEST(Holds, TheMeanPoseIsThatOfItsMiddle) {
  const auto made = four_places();
  const auto hold = find_holds(made.poses).at(2);
  const auto mean = mean_pose(hold);
  EXPECT_NEAR(mean.time_s, 0.5 * (hold.front().time_s + hold.back().time_s), 1e-9);
  EXPECT_NEAR(mean.joints.x(), mean.time_s, 1e-9);
  EXPECT_NEAR(so3_log(mean.marker.rotation).x(), 0.2, 1e-9);
  EXPECT_LT((mean.marker.rotation * kTip + mean.marker.translation - made.places[2]).norm(), 0.04e-3);
  EXPECT_NEAR(mean.marker.covariance(3, 3), kNoise * kNoise / static_cast<double>(hold.size()), 1e-14);
  EXPECT_NEAR(mean.marker.systematic(0, 0), 1e-8, 1e-14);
}

TEST(Holds, AKeyMeansTheHoldThatLastsOrTheNextOne) {
  const auto made = four_places();
  const auto holds = find_holds(made.poses);
  ASSERT_EQ(holds.size(), 4u);
  std::size_t missed = 0;
  // In the second, before the third and, twice, in the fourth; and one after all of them.
  const double in_second = holds[1].front().time_s + 0.5, before_third = holds[2].front().time_s - 0.3,
               in_fourth = holds[3].front().time_s + 0.2;
  const auto meant = holds_at(holds, {in_second, before_third, in_fourth, in_fourth + 0.1, 100.0}, missed);
  ASSERT_EQ(meant.size(), 3u);
  EXPECT_EQ(missed, 2u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(meant[i].front().time_s, holds[i + 1].front().time_s);
  // One that comes too late, and one after which another key was pressed.
  EXPECT_TRUE(holds_at(holds, {holds[1].back().time_s + 0.2}, missed, 0.3).empty());
  EXPECT_EQ(missed, 1u);
  EXPECT_EQ(holds_at(holds, {before_third - 0.1, before_third}, missed).size(), 1u);
  EXPECT_EQ(missed, 1u);
}

}  // namespace
}  // namespace palpate::calibration::session
