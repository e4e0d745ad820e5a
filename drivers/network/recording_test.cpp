#include "drivers/network/recording.h"

#include <gtest/gtest.h>

#include "palpate/core/file.h"
#include "tests/scratch_folder.h"

namespace palpate::drivers::network {
namespace {

const std::filesystem::path kPivots = std::filesystem::path(PALPATE_DATA_DIR) / "plus_eight_landmark_pivots" /
                                      "EightLandmarkPointsTrackedForPhantomRegistration.igs.mha";

std::vector<RecordedPose> at_times(const std::vector<double>& times) {
  std::vector<RecordedPose> poses;
  for (const double time : times) poses.push_back({time, "Tool", {}});
  return poses;
}

TEST(Recording, HoldsAllTransformsOfASequenceOrThoseNamed) {
  const auto all = read_recording(kPivots);
  ASSERT_TRUE(all.has_value()) << all.error().message;
  EXPECT_EQ(all->size(), 2000u);
  EXPECT_EQ((*all)[0].tool, "ReferenceToTracker");
  EXPECT_EQ((*all)[1].tool, "StylusToTracker");
  EXPECT_EQ((*all)[0].time_s, (*all)[1].time_s);
  const auto chain = read_recording(kPivots, {"StylusToReference"});
  ASSERT_TRUE(chain.has_value()) << chain.error().message;
  EXPECT_EQ(chain->size(), 1000u);
  EXPECT_FALSE(read_recording(kPivots, {"StylusToMoon"}).has_value());
  EXPECT_FALSE(read_recording("nowhere.igs.mha").has_value());
}

TEST(Recording, TablesAreOneToolAndNeedTimes) {
  const ScratchFolder folder;
  const std::string poses = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n2,1,2,3,1,0,0,0\n1,4,5,6,1,0,0,0\n";
  ASSERT_TRUE(write_file(folder / "poses.csv", poses).has_value());
  const auto read = read_recording(folder / "poses.csv", {"Pointer"});
  ASSERT_TRUE(read.has_value()) << read.error().message;
  ASSERT_EQ(read->size(), 2u);
  EXPECT_EQ((*read)[0].time_s, 1.0) << "in order of time";
  EXPECT_EQ((*read)[0].tool, "Pointer");
  EXPECT_FALSE(read_recording(folder / "poses.csv", {"a", "b"}).has_value());
  ASSERT_TRUE(
      write_file(folder / "early.csv", "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n-2,1,2,3,1,0,0,0\n").has_value());
  EXPECT_FALSE(read_recording(folder / "early.csv").has_value());
  ASSERT_TRUE(write_file(folder / "timeless.csv", "x_mm,y_mm,z_mm,qw,qx,qy,qz\n1,2,3,1,0,0,0\n").has_value());
  EXPECT_FALSE(read_recording(folder / "timeless.csv").has_value());
}

TEST(Recording, SamplesOfAnArmAreNoToolsMotion) {
  const ScratchFolder folder;
  const auto read = [&](const std::string& content) {
    EXPECT_TRUE(write_file(folder / "table.csv", content).has_value());
    return read_recording(folder / "table.csv");
  };
  const std::string joints = "time_s,joint_1_deg,joint_2_deg,joint_3_deg,";
  const auto arm = read(joints +
                        "marker_x_mm,marker_y_mm,marker_z_mm,marker_qw,marker_qx,marker_qy,marker_qz\n"
                        "1,10,20,30,1,2,3,1,0,0,0\n");
  ASSERT_FALSE(arm.has_value());
  EXPECT_NE(arm.error().message.find("samples of an arm"), std::string::npos) << arm.error().message;
  // A pivot that an arm held is a motion of its own, with joint readings beside it.
  const auto pivot = read(joints + "x_mm,y_mm,z_mm,qw,qx,qy,qz\n1,10,20,30,1,2,3,1,0,0,0\n");
  EXPECT_TRUE(pivot.has_value()) << pivot.error().message;
}

TEST(Replay, PosesComeWhenTheyAreDueWithTheStampsOfTheRecording) {
  Replay replay(at_times({10.0, 10.5, 11.0}), 2.0);
  EXPECT_EQ(replay.take(0.0)->time_s, 10.0);
  EXPECT_FALSE(replay.take(0.2).has_value());
  EXPECT_EQ(*replay.next_due(), 0.25);
  EXPECT_EQ(replay.take(0.25)->time_s, 10.5);
  EXPECT_EQ(replay.take(99.0)->time_s, 11.0) << "late, but none is left out";
  EXPECT_FALSE(replay.take(1e9).has_value());
  EXPECT_FALSE(replay.next_due().has_value());
}

TEST(Replay, LoopsWithoutEverRunningBackwards) {
  Replay replay(at_times({10.0, 10.5, 11.0}), 1.0, true);
  double last = 0.0;
  for (int i = 0; i < 100; ++i) {
    const auto pose = replay.take(1e6);
    ASSERT_TRUE(pose.has_value());
    EXPECT_GT(pose->time_s, last);
    last = pose->time_s;
  }
  EXPECT_EQ(last, 10.0 + 99 * 0.5);
  Replay still(at_times({3.0}), 1.0, true);
  EXPECT_EQ(still.take(0.0)->time_s, 3.0);
  EXPECT_EQ(*still.next_due(), 1.0) << "a single pose must not spin";
}

}  // namespace
}  // namespace palpate::drivers::network
