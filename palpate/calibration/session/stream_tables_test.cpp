#include "palpate/calibration/session/stream_tables.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "palpate/calibration/pivot.h"
#include "palpate/core/csv.h"
#include "palpate/core/random.h"
#include "palpate/device/pose_file.h"

namespace palpate::calibration::session {
namespace {

// A stylus that is held in some poses, its arm reading the same as its place; the clocks as they are.
device::DeviceStreams held(int poses) {
  device::DeviceStreams streams;
  Random random(2, "stream tables");
  int ms = 0;
  const auto say = [&](double place) {
    const double t = 1e-3 * ms;
    device::ArmSample arm;
    arm.stamp = Instant<ArmClock>::from_seconds(t);
    arm.joints = Vector3(place, 0.0, 0.0);
    streams.add(arm, Instant<PhysicsClock>::from_seconds(t));
    if (ms % 10 == 0) {
      device::TrackerSample sample;
      sample.stamp = Instant<TrackerClock>::from_seconds(t);
      sample.marker = device::MarkerId::tip_marker;
      sample.seen = true;
      sample.translation = Vector3(place + random.normal(0.05e-3), 0.0, 0.0);
      streams.add(sample, Instant<PhysicsClock>::from_seconds(t));
    }
    ++ms;
  };
  for (int i = 0; i < poses; ++i) {
    for (int k = 0; k < 500; ++k) say(0.05 * (i + 0.002 * k));
    for (int k = 0; k < 900; ++k) say(0.05 * (i + 1));
  }
  return streams;
}

TEST(StreamTables, AnArmsRowIsTheMeanOfAPoseHeldStill) {
  const auto poses = still_arm_poses(held(12));
  ASSERT_EQ(poses.size(), 12u);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_NEAR(poses[i].joints.x(), 0.05 * static_cast<double>(i + 1), 0.02e-3);
    EXPECT_NEAR(poses[i].marker.translation.x(), 0.05 * static_cast<double>(i + 1), 0.04e-3);
  }
  const auto text = table_from_streams(held(12), "arm");
  ASSERT_TRUE(text) << text.error().message;
  EXPECT_EQ(parse_csv(*text, "arm")->rows.size(), 12u);
  // So few poses say nothing of an arm: all that was seen does.
  const auto moving = table_from_streams(held(3), "arm");
  ASSERT_TRUE(moving);
  EXPECT_GT(parse_csv(*moving, "arm")->rows.size(), 300u);
}

// Readings of an arm that states its place are a place, in the table as on the wire.
TEST(StreamTables, AnArmThatStatesItsPlaceHasMillimetresInItsColumns) {
  device::ArmModel model;
  model.kind = device::ArmModel::Kind::cartesian;
  const auto text = table_from_streams(held(12), "arm", Vector3::Zero(), model);
  ASSERT_TRUE(text) << text.error().message;
  EXPECT_TRUE(text->starts_with("arm_x_mm,arm_y_mm,arm_z_mm,gimbal_1_deg,")) << text->substr(0, 80);
  const auto table = parse_csv(*text, "arm");
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_NEAR(table->rows[3][*table->find("arm_x_mm")], 50.0 * 4, 0.02) << "mm of the metres that it stated";
  const auto pivot = table_from_streams(held(12), "pivot", Vector3::Zero(), model);
  ASSERT_TRUE(pivot) << pivot.error().message;
  EXPECT_NE(pivot->find(",arm_x_mm,"), std::string::npos);
  EXPECT_EQ(pivot->find("joint_1"), std::string::npos);
}

TEST(StreamTables, WhatIsNotThereIsRefused) {
  const auto streams = held(1);
  EXPECT_TRUE(table_from_streams(streams, "pivot"));
  EXPECT_FALSE(table_from_streams(streams, "hand"));
  EXPECT_FALSE(table_from_streams(streams, "corners"));
  EXPECT_FALSE(table_from_streams({}, "arm"));
}

// The recording of eight hollows in which others have marked the rests by hand.
TEST(StreamTables, TheRestsOfARealRecordingAreThoseThatWereMarked) {
  const auto file = device::read_poses(
      std::filesystem::path(PALPATE_DATA_DIR) / "plus_eight_landmark_pivots" / "stylus_to_reference.csv",
      {.transform = {}, .segment_column = "landmark"});
  ASSERT_TRUE(file) << file.error().message;
  std::vector<TrackedPose> poses;
  for (const auto& pose : file->poses) {
    TrackedPose one;
    one.time_s = pose.time_s;
    one.marker.seen = true;
    one.marker.rotation = pose.rotation;
    one.marker.translation = pose.translation;
    poses.push_back(one);
  }
  const auto segments = pivot_segments(poses);
  ASSERT_TRUE(segments) << segments.error().message;
  // Of each rest that was marked most poses are in one of ours, and in no other.
  std::vector<PivotPose> ours, marked;
  for (int number = 0; number < 8; ++number) {
    int of_it = 0, same = 0;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (file->poses[i].segment != number) {
        EXPECT_FALSE(file->poses[i].segment >= 0 && (*segments)[i] == number + 1) << i;
        continue;
      }
      ++of_it;
      same += (*segments)[i] == number + 1 ? 1 : 0;
    }
    EXPECT_GT(same, 0.85 * of_it) << number;
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    ours.push_back({poses[i].marker.rotation, poses[i].marker.translation, (*segments)[i] - 1, std::nullopt,
                    poses[i].time_s});
    marked.push_back({poses[i].marker.rotation, poses[i].marker.translation, file->poses[i].segment,
                      std::nullopt, poses[i].time_s});
  }
  const auto a = calibrate_pivot(ours), b = calibrate_pivot(marked);
  ASSERT_TRUE(a && b);
  EXPECT_LT((a->value.tip - b->value.tip).norm(), 0.25e-3);
  for (std::size_t k = 0; k < 8; ++k)
    EXPECT_LT((a->value.segments[k].pivot - b->value.segments[k].pivot).norm(), 0.25e-3) << k;
}

}  // namespace
}  // namespace palpate::calibration::session
