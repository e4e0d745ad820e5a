// The real-time run's overlay errors beside closed forms, from files as the two processes write them.
#include "palpate/evaluation/realtime_overlay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "palpate/core/csv.h"
#include "palpate/server/graphics/pose_log.h"
#include "palpate/sim/exposure_log.h"
#include "tests/scratch_folder.h"

namespace palpate::evaluation {
namespace {

constexpr double kFocalPx = 560.0, kTurnRate = 0.8, kFrameStep = 1.0 / 30.0;  // px, rad/s, s

device::CameraModel ideal_lens() {
  device::CameraModel lens;
  lens.width = 640, lens.height = 480;
  lens.fx = lens.fy = kFocalPx;
  lens.cx = 319.5, lens.cy = 239.5;
  return lens;
}

// A camera in World's origin that turns steadily about its own vertical axis: at frame i it looks so far to
// the side of the point straight ahead.
Pose<World, CameraOptical> turned(double angle) {
  return {Quaternion(Eigen::AngleAxisd(angle, Vector3::UnitY())), Vector3::Zero()};
}
double angle_at(int frame) { return kTurnRate * kFrameStep * (frame - 10); }

// 21 frames, 0.7 s; each drawn with the pose of so many frames before; those of `late` with the tip of the
// frame before.
class PlayedRun {
 public:
  explicit PlayedRun(int pose_lag, const std::vector<int>& late = {}) {
    auto truth = sim::ExposureLog::begin(truth_path());
    auto poses = server::graphics::PoseLog::begin(folder_.path());
    EXPECT_TRUE(truth && poses);
    for (int i = 0; i < kFrames; ++i) {
      sim::TrueView view;
      view.X_world_camera = turned(angle_at(i));
      view.X_world_base.translation = tip_at(i) - device::phantom_tip(view.theta, view.lengths).m;
      truth->add(static_cast<std::uint64_t>(100 + i), 1'000'000'000LL * i, view, {Duration(i)});
      if (i < 2) continue;
      server::graphics::FrameRecord record;
      record.number = static_cast<std::uint64_t>(i);
      record.camera_frame = static_cast<std::uint64_t>(100 + i);
      record.have_state = true;
      const bool belated = std::find(late.begin(), late.end(), i) != late.end();
      record.late = belated;
      record.state.bodies[scene::kCarried].set_p(tip_at(i - (belated ? 1 : 0)) + scene_.carried_offset);
      record.X_world_camera = turned(angle_at(i - pose_lag));
      record.pose_source = server::graphics::PoseSource::refined;
      record.expected_world_px = 0.5;
      poses->add(record, scene_, kFrameStep * i);
    }
    EXPECT_TRUE(truth->finish() && poses->finish());
  }
  Expected<Json> judged(double warm_up_s = 0.0) {
    return evaluate_overlay(poses_path(), truth_path(),
                            {.lens = ideal_lens(),
                             .true_lens = ideal_lens(),
                             .points = {{Vector3(0, 0, 2), Vector3(0, 0, 2)}},
                             .warm_up_s = warm_up_s});
  }
  std::filesystem::path truth_path() const { return folder_.path() / "realtime_truth.csv"; }
  std::filesystem::path poses_path() const { return folder_.path() / "realtime_poses.csv"; }
  static constexpr int kFrames = 21;

 private:
  // The tip crosses the view in front of a camera that does not move with it.
  static Vector3 tip_at(int frame) { return {0.02 * (frame - 10), 0.0, 1.0}; }
  ScratchFolder folder_;
  scene::SceneDescription scene_;
};

TEST(RealtimeOverlay, PicturesOfTheirMomentHaveNoError) {
  const auto judged = PlayedRun(0).judged();
  ASSERT_TRUE(judged) << judged.error().message;
  EXPECT_LT((*judged)["world_px_rms"].get<double>(), 1e-7);
  EXPECT_LT((*judged)["tip_px_rms"].get<double>(), 1e-7);
  EXPECT_EQ((*judged)["frames"], 19);
  EXPECT_EQ((*judged)["late"], 0);
  EXPECT_EQ((*judged)["pose_from"]["refined"], 19);
}

TEST(RealtimeOverlay, APoseOneFrameOldCostsTheDifferenceOfTwoTangents) {
  const auto judged = PlayedRun(1).judged();
  ASSERT_TRUE(judged) << judged.error().message;
  double sum = 0.0;
  for (int i = 2; i < PlayedRun::kFrames; ++i)
    sum += std::pow(kFocalPx * (std::tan(angle_at(i)) - std::tan(angle_at(i - 1))), 2);
  EXPECT_NEAR((*judged)["world_px_rms"].get<double>(), std::sqrt(sum / 19.0), 1e-7);
  // By hand: 560 px at 0.8 rad/s, a thirtieth of a second.
  EXPECT_NEAR((*judged)["world_px_rms"].get<double>(), 560.0 * 0.8 / 30.0, 0.4);
  EXPECT_NEAR((*judged)["own_estimate_over_true"].get<double>(), 0.5 / std::sqrt(sum / 19.0), 1e-7);
}

TEST(RealtimeOverlay, LateFramesAreToldApartFromThoseInTime) {
  const auto judged = PlayedRun(0, {8, 12}).judged();
  ASSERT_TRUE(judged) << judged.error().message;
  EXPECT_EQ((*judged)["late"], 2);
  EXPECT_LT((*judged)["tip_px_rms_in_time"].get<double>(), 1e-7);
  // A tip 20 mm away across the view at a metre's distance, seen by a camera turned by `angle`.
  double sum = 0.0;
  for (const int i : {8, 12}) {
    const auto u = [&](double x) { return kFocalPx * std::tan(std::atan(x) - angle_at(i)); };
    sum += std::pow(u(0.02 * (i - 10)) - u(0.02 * (i - 11)), 2);
  }
  EXPECT_NEAR((*judged)["tip_px_rms_late"].get<double>(), std::sqrt(sum / 2.0), 1e-7);
  EXPECT_NEAR((*judged)["tip_px_rms"].get<double>(), std::sqrt(sum / 19.0), 1e-7);
}

TEST(RealtimeOverlay, EachFramesErrorsStandBesideItAndTheFirstDoNotCount) {
  PlayedRun run(1);
  const auto judged = run.judged(0.5);
  ASSERT_TRUE(judged) << judged.error().message;
  EXPECT_EQ((*judged)["frames"], PlayedRun::kFrames - 15);
  const auto table = read_csv(run.poses_path(), {{"*"}});
  ASSERT_TRUE(table) << table.error().message;
  ASSERT_EQ(table->rows.size(), 19u);
  EXPECT_NEAR(table->rows[0][*table->find("world_px")],
              kFocalPx * (std::tan(angle_at(2)) - std::tan(angle_at(1))), 1e-6);
}

TEST(RealtimeOverlay, APictureWhoseImageNobodyKnowsOfIsCountedAndNotJudged) {
  PlayedRun run(0);
  const auto taken = read_csv(run.truth_path());
  ASSERT_TRUE(taken);
  CsvWriter some(taken->header);
  for (std::size_t i = 0; i < 10; ++i) some.row(taken->text[i]);
  std::ofstream(run.truth_path()) << some.content();
  const auto judged = run.judged();
  ASSERT_TRUE(judged) << judged.error().message;
  EXPECT_EQ((*judged)["frames"], 8);
  EXPECT_EQ((*judged)["unjudged"], 11);
}

TEST(RealtimeOverlay, AFileWithoutTheTruePoseIsRefused) {
  PlayedRun run(0);
  std::ofstream(run.truth_path()) << "frame,mid_exposure_monotonic_ns\n100,5\n";
  const auto judged = run.judged();
  ASSERT_FALSE(judged);
  EXPECT_NE(judged.error().message.find("cam_x_m"), std::string::npos) << judged.error().message;
}

}  // namespace
}  // namespace palpate::evaluation
