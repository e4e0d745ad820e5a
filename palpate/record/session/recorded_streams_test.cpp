// Raw streams out of a recording, and the sequence made of them.
#include "palpate/record/session/recorded_streams.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/file.h"
#include "palpate/device/pose_file.h"
#include "palpate/record/session/device_messages.h"
#include "palpate/record/session/export_sequence.h"
#include "palpate/record/session/session_recording.h"
#include "palpate/record/session/tick_messages.h"
#include "tests/scratch_folder.h"

namespace palpate::record::session {
namespace {

constexpr int kWidth = 4, kHeight = 3;

// Two seconds: an arm each millisecond, a tracker each 10 ms whose pointer is at x = t and hidden for t in [1.0, 1.2), a camera each 50 ms
// whose pictures are packed late: each comes behind the next one's stamp. Clocks of their own, nothing waits.
std::filesystem::path recorded(const ScratchFolder& folder) {
  const auto recording =
      std::move(*SessionRecording::begin(folder / "s.mcap", {.recorder = "test", .on_error = {}}));
  auto& arm = recording->stream("/arm/sample", "palpate.recording.ArmSample");
  auto& tracker = recording->stream("/tracker/sample", "palpate.recording.TrackerSample");
  auto& stamps = recording->stream("/camera/left/stamp", "palpate.recording.CameraStamp");
  auto& images = recording->stream("/camera/left/image", "foxglove.RawImage");
  std::optional<std::pair<device::CameraImage, std::uint64_t>> packed;
  const auto write_picture = [&] {
    if (packed)
      images.write(packed->second, packed->second,
                   encode_raw_image(packed->first, packed->second, "camera_left"));
    packed.reset();
  };
  for (int ms = 0; ms < 2000; ++ms) {
    const auto now = recording->log_time(5'000'000'000 + 1'000'000ll * ms);
    RecordedHapticTick tick;
    tick.tick.sample.stamp = {Duration(77'000'000'000 + 1'000'000ll * ms)};
    tick.tick.sample.joints = Vector3(1e-3 * ms, 0.0, 0.0);
    tick.inputs.exact = false;
    arm.write(now, now, encode_sample(tick));
    if (ms % 10 == 0) {
      RecordedTrackerSample sample;
      sample.sample.stamp = {Duration(9'000'000'000 + 1'000'000ll * ms)};
      sample.sample.marker = device::MarkerId::pointer;
      sample.sample.seen = ms < 1000 || ms >= 1200;
      sample.sample.translation = Vector3(1e-3 * ms, 1.0 / 3.0, -2.0);
      tracker.write(now, now, encode(sample));
    }
    if (ms % 50 == 5) {
      RecordedCameraStamp stamp;
      stamp.image.mid_exposure = {Duration(123'000'000'000 + 1'000'000ll * ms)};
      stamp.image.frame = static_cast<std::uint64_t>(ms);
      stamp.image.width = kWidth, stamp.image.height = kHeight;
      stamps.write(now, now, encode(stamp));
      write_picture();
      stamp.image.rgb.assign(3 * kWidth * kHeight, static_cast<std::uint8_t>(ms / 50));
      packed = {stamp.image, now};
    }
  }
  write_picture();
  recording->close();
  return folder / "s.mcap";
}

TEST(RecordedStreams, AllAreOnOneTimeBase) {
  const ScratchFolder folder;
  std::vector<std::pair<std::uint64_t, int>> pictures;
  StreamsToRead what;
  what.camera = "left";
  std::vector<Instant<CameraClock>> taken;
  what.picture = [&](const device::CameraImage& image) {
    pictures.emplace_back(image.frame, image.rgb.at(0));
    taken.push_back(image.mid_exposure);
  };
  const auto read = read_streams(recorded(folder), what);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->arm, 2000u);
  EXPECT_EQ(read->tracker, 200u);
  EXPECT_EQ(read->images, 40u);
  EXPECT_EQ(read->pictures, 40u);
  EXPECT_EQ(read->unread, 0u);
  EXPECT_NEAR(read->seconds, 1.999, 1e-9);
  ASSERT_EQ(pictures.size(), 40u);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    EXPECT_EQ(pictures[i].first, 50 * i + 5);
    EXPECT_EQ(pictures[i].second, static_cast<int>(i)) << "a picture belongs to its own stamp";
    EXPECT_NEAR(read->streams.host_time(taken[i]), 1e-3 * static_cast<double>(pictures[i].first), 20e-6);
  }
  const auto poses = read->streams.poses(device::MarkerId::pointer);
  EXPECT_EQ(poses.size(), 179u) << "the first is before the arm's readings";
  for (const auto& pose : poses) {
    EXPECT_NEAR(pose.time_s, pose.marker.translation.x(), 20e-6);
    EXPECT_NEAR(pose.joints.x(), pose.marker.translation.x(), 40e-6);
    EXPECT_EQ(pose.marker.translation.y(), 1.0 / 3.0);
  }
}

TEST(RecordedStreams, APartHasTheSamplesOfItsTimeAndTheSameTimes) {
  const ScratchFolder folder;
  StreamsToRead what;
  what.span = {0.5, 1.5};
  const auto read = read_streams(recorded(folder), what);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->arm, 1001u);
  EXPECT_EQ(read->images, 0u) << "no camera was asked for";
  const auto poses = read->streams.marker_poses(device::MarkerId::pointer);
  ASSERT_EQ(poses.size(), 101u);
  EXPECT_NEAR(poses.front().time_s, 0.5, 20e-6);
  EXPECT_EQ(read->streams.missed(device::MarkerId::pointer), 20);
}

TEST(RecordedStreams, AFileThatIsNoRecordingHoldsNothing) {
  const ScratchFolder folder;
  ASSERT_TRUE(write_file(folder / "none.mcap", "nothing of the kind"));
  const auto read = read_streams(folder / "none.mcap", {});
  EXPECT_TRUE(!read || read->arm + read->tracker + read->images == 0);
  EXPECT_FALSE(read_streams(folder / "missing.mcap", {}));
}

TEST(ExportSequence, APoseIsBetweenItsSeenNeighboursAtMidExposure) {
  const ScratchFolder folder;
  SequenceOptions how;
  how.names[device::MarkerId::pointer] = "Stylus";
  const auto report = export_sequence(recorded(folder), folder / "s.igs.mha", how);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->frames, 40u);
  // Of t = 0.005, 0.055 ... those at 1.005, 1.055, 1.105 and 1.155 were taken while it was hidden; that at 0.955 lies between two that
  // were seen.
  EXPECT_EQ(report->transforms.at("StylusToTracker").valid, 36u);
  EXPECT_EQ(report->transforms.at("StylusToTracker").invalid, 4u);
  const auto poses =
      device::read_poses(folder / "s.igs.mha", {.transform = "StylusToTracker", .segment_column = {}});
  ASSERT_TRUE(poses) << poses.error().message;
  ASSERT_EQ(poses->poses.size(), 36u);
  for (const auto& pose : poses->poses) {
    EXPECT_NEAR(pose.translation.x(), pose.time_s, 40e-6);
    EXPECT_NEAR(std::fmod(pose.time_s + 1e-4, 0.05), 0.0051, 40e-6);
  }
  const auto bytes = read_file(folder / "s.igs.mha");
  ASSERT_TRUE(bytes);
  const std::string end = "ElementDataFile = LOCAL\n";
  const auto at = bytes->find(end) + end.size();
  ASSERT_EQ(bytes->size() - at, 40u * 3 * kWidth * kHeight);
  for (std::size_t i = 0; i < 40; ++i)
    EXPECT_EQ((*bytes)[at + 3 * kWidth * kHeight * i], static_cast<char>(i));
}

TEST(ExportSequence, TheCamerasDelayIsTakenOff) {
  const ScratchFolder folder;
  SequenceOptions how;
  how.camera_after_tracker_s = 0.02;
  ASSERT_TRUE(export_sequence(recorded(folder), folder / "s.igs.mha", how));
  const auto poses = device::read_poses(folder / "s.igs.mha");
  ASSERT_TRUE(poses) << poses.error().message;
  for (const auto& pose : poses->poses) EXPECT_NEAR(pose.translation.x(), pose.time_s - 0.02, 40e-6);
}

TEST(ExportSequence, WithoutPicturesItIsRefusedAndNoFileIsThere) {
  const ScratchFolder folder;
  SequenceOptions how;
  how.camera = "right";
  const auto report = export_sequence(recorded(folder), folder / "s.igs.mha", how);
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("right camera"), std::string::npos) << report.error().message;
  EXPECT_FALSE(is_there(folder / "s.igs.mha"));
}

}  // namespace
}  // namespace palpate::record::session
