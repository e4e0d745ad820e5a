// A tracker over the network and a calibration, which are neighbours.
#include <gtest/gtest.h>

#include <filesystem>

#include "drivers/network/marker_tracker.h"
#include "drivers/network/recording.h"
#include "drivers/openigtlink/loopback_for_tests.h"
#include "palpate/calibration/pivot.h"
#include "palpate/device/pose_file.h"

namespace palpate::drivers::openigtlink {
namespace {

using Stamp = Instant<TrackerClock>;

// The recording as a live tracker: file -> messages -> socket -> driver -> pivot calibration, beside the
// calibration of the file. Which frames rest in which landmark stands in the table made from it.
TEST(TrackerAndPivot, ARecordingComesThroughWithTheSamePivot) {
  const auto folder = std::filesystem::path(PALPATE_DATA_DIR) / "plus_eight_landmark_pivots";
  const auto table = device::read_poses(folder / "stylus_to_reference.csv", {.segment_column = "landmark"});
  ASSERT_TRUE(table.has_value()) << table.error().message;
  auto recording = network::read_recording(
      folder / "EightLandmarkPointsTrackedForPhantomRegistration.igs.mha", {"StylusToReference"});
  ASSERT_TRUE(recording.has_value()) << recording.error().message;
  ASSERT_EQ(recording->size(), table->poses.size());
  std::vector<calibration::PivotPose> offline;
  for (std::size_t i = 0; i < recording->size(); ++i)
    offline.push_back({(*recording)[i].pose.rotation, (*recording)[i].pose.translation,
                       table->poses[i].segment, std::nullopt});

  const auto server = server_at();
  network::MarkerTracker tracker(client_of(server->address()),
                                 {.markers = {{"StylusToReference", device::MarkerId::tip_marker}}});
  ASSERT_TRUE(comes_true([&] { return server->state().clients == 1; }));
  network::Replay replay(std::move(*recording));
  while (const auto due = replay.next_due()) {  // as fast as the queues can be relied on to lose nothing
    const auto pose = replay.take(*due);
    ASSERT_TRUE(server->publish(pose->tool, Stamp::from_seconds(pose->time_s), pose->pose).has_value());
    if (server->state().published % 500 == 0) {
      ASSERT_TRUE(server->drain(std::chrono::minutes(2)));
    }
  }
  ASSERT_TRUE(comes_true([&] { return tracker.state().samples == table->poses.size(); }));

  const auto samples = tracker.poll();
  ASSERT_EQ(samples.size(), table->poses.size());
  std::vector<calibration::PivotPose> live;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto& pose = table->poses[i];
    EXPECT_NEAR((samples[i].stamp - samples[0].stamp).count() * 1e-9, pose.time_s - table->poses[0].time_s,
                2e-3);
    live.push_back({samples[i].rotation, samples[i].translation, pose.segment, std::nullopt});
  }
  const auto tip_live = calibration::calibrate_pivot(live),
             tip_offline = calibration::calibrate_pivot(offline);
  ASSERT_TRUE(tip_live.has_value() && tip_offline.has_value());
  // float32 on the wire: 3e-5 mm of 300 mm, which a thousand poses average
  EXPECT_LT(1e3 * (tip_live->value.tip - tip_offline->value.tip).norm(), 1e-4);
  EXPECT_LT((1e3 * tip_live->value.tip - Vector3(109.6255, 6.6077, 2.7924)).norm(), 0.05);  // ORIGIN.md
  EXPECT_NEAR(1e3 * rms_per_component(tip_live->residuals), 0.2922, 0.003);
}

}  // namespace
}  // namespace palpate::drivers::openigtlink
