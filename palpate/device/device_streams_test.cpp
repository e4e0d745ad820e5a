#include "palpate/device/device_streams.h"

#include <gtest/gtest.h>

#include "palpate/core/random.h"

namespace palpate::device {
namespace {

// An arm whose first joint tells the true time, and a tracker whose x does; each stamps by a clock of its own.
struct Laboratory {
  Random random{7, "device streams"};
  DeviceStreams streams;

  static Instant<PhysicsClock> arrived(double t) { return Instant<PhysicsClock>::from_seconds(t); }
  void arm(double t) {
    ArmSample sample;
    sample.stamp = Instant<ArmClock>::from_seconds(1000.0 + t * (1.0 + 20e-6));
    sample.joints = Vector3(t, -t, 0.5);
    sample.gimbal = Vector3(0.0, t, 0.0);
    streams.add(sample, arrived(t + 0.0002 + random.uniform(0.0, 0.0003)));
  }
  void tracker(double t, MarkerId marker, bool seen = true) {
    TrackerSample sample;
    sample.stamp = Instant<TrackerClock>::from_seconds(50.0 + t * (1.0 - 30e-6));
    sample.marker = marker;
    sample.seen = seen;
    sample.translation = Vector3(t, 0.0, 0.0);
    streams.add(sample, arrived(t + 0.004 + random.uniform(0.0, 0.002)));
  }
  void run(double seconds_long) {
    for (int ms = 0; ms < static_cast<int>(1e3 * seconds_long); ++ms) {
      const double t = 1e-3 * ms;
      arm(t);
      if (ms % 10 != 0) continue;
      tracker(t, MarkerId::tip_marker, ms % 100 != 0);
      tracker(t, MarkerId::pointer);
    }
  }
};

TEST(DeviceStreams, ReadingsAreThoseOfThePosesMoment) {
  Laboratory laboratory;
  laboratory.run(40.0);
  const auto poses = laboratory.streams.poses(MarkerId::tip_marker);
  ASSERT_GT(poses.size(), 3500u);
  for (const auto& pose : poses) {
    // The tracker's smallest latency beyond the arm's stays.
    EXPECT_NEAR(pose.joints.x() - pose.marker.translation.x(), 0.004 - 0.0002, 0.4e-3);
    EXPECT_NEAR(pose.time_s - pose.marker.translation.x(), 0.004, 0.4e-3);
    EXPECT_NEAR(pose.gimbal.y(), pose.joints.x(), 1e-9);
  }
  EXPECT_EQ(laboratory.streams.missed(MarkerId::tip_marker), 400);
  EXPECT_EQ(laboratory.streams.marker_poses(MarkerId::tip_marker).size(), 4000u);
}

TEST(DeviceStreams, NoReadingIsMadeUpWhereTheArmWasSilent) {
  Laboratory laboratory;
  for (int ms = 0; ms < 4000; ++ms) {
    const double t = 1e-3 * ms;
    if (ms < 2000 || ms > 2500) laboratory.arm(t);
    if (ms % 10 == 0) laboratory.tracker(t, MarkerId::tip_marker);
  }
  for (const auto& pose : laboratory.streams.poses(MarkerId::tip_marker))
    EXPECT_FALSE(pose.marker.translation.x() > 2.01 && pose.marker.translation.x() < 2.48);
}

TEST(DeviceStreams, ReadingsOfOtherArmsAreCounted) {
  DeviceStreams streams;
  ArmSample sample;
  sample.joints = JointVector::filled(6, 0.1);
  streams.add(sample, Laboratory::arrived(0.0));
  EXPECT_EQ(streams.other_arms(), 1u);
  EXPECT_TRUE(streams.arm_readings().empty());
}

TEST(PoseBetween, IsOnlyWhereBothNeighboursWereSeenAndNear) {
  std::vector<TrackedPose> poses(5);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].time_s = 0.01 * static_cast<double>(i);
    poses[i].marker.seen = i != 3;
    poses[i].marker.translation = Vector3(static_cast<double>(i), 0.0, 0.0);
    poses[i].marker.rotation = so3_exp(Vector3(0.0, 0.0, 0.1 * static_cast<double>(i)));
    poses[i].marker.covariance = Matrix6::Identity();
  }
  poses[4].time_s = 5.0;
  const auto between = pose_between(poses, 0.0125);
  ASSERT_TRUE(between);
  EXPECT_NEAR(between->marker.translation.x(), 1.25, 1e-9);
  EXPECT_NEAR(so3_log(between->marker.rotation).z(), 0.125, 1e-9);
  EXPECT_NEAR(between->marker.covariance(0, 0), 0.75 * 0.75 + 0.25 * 0.25, 1e-9);
  EXPECT_TRUE(pose_between(poses, 0.02)) << "a pose of its own";
  EXPECT_FALSE(pose_between(poses, 0.025)) << "the next one was not seen";
  EXPECT_FALSE(pose_between(poses, 0.03)) << "it was not seen";
  poses[3].marker.seen = true;
  EXPECT_FALSE(pose_between(poses, 1.0)) << "a gap";
  EXPECT_FALSE(pose_between(poses, -0.001));
  EXPECT_FALSE(pose_between(poses, 5.1));
}

}  // namespace
}  // namespace palpate::device
