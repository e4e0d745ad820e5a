#include "palpate/calibration/session/guided_poses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "palpate/calibration/session/arm_observations.h"
#include "palpate/core/statistics.h"
#include "palpate/core/units.h"
#include "palpate/evaluation/arm_comparison.h"
#include "palpate/evaluation/world_sample.h"

namespace palpate::evaluation {
namespace {

using sim::Simulator;
using sim::config::reference_world;

sim::config::WorldFile white_world() {
  auto file = reference_world();
  file.tracker.white_rms = 0.0002;
  file.tracker.bias_rms = 0.0;
  return file;
}

calibration::session::GuidanceOptions guidance_in(const sim::config::WorldFile& file) {
  calibration::session::GuidanceOptions options;
  options.arm.free.lengths = false;
  options.tip = file.tip_marker.tip;
  options.reach = reach_of(file);
  return options;
}

// What the arm really is, as an estimate would say it.
calibration::ArmSolution true_arm(const Simulator& world) {
  calibration::ArmSolution arm;
  arm.model.lengths = world.truth().lengths;
  arm.gain = world.truth().joints.gain;
  arm.offset = world.truth().joints.offset;
  arm.X_world_base = world.truth().X_world_base;
  arm.tip_in_marker = world.truth().tip_in_marker;
  arm.tip_known = true;
  return arm;
}

double error_to_truth(const std::vector<calibration::session::TrackedPose>& poses, const Simulator& world) {
  calibration::ArmOptions options;
  options.free.lengths = false;
  const auto samples = calibration::session::arm_observations(poses, world.file().tip_marker.tip);
  const auto estimate = calibration::calibrate_arm(samples, device::ArmModel(), options);
  if (!estimate) throw std::runtime_error(estimate.error().message);
  double sum = 0.0;
  const auto places = judging_poses(world.file(), 1, 300);
  const calibration::ArmSolution truth = true_arm(world);
  for (const auto& psi : places)
    sum += (calibration::predict_tip(estimate->value, psi).m - calibration::predict_tip(truth, psi).m).norm();
  return sum / static_cast<double>(places.size());
}

// 10 mm and 5 degrees rms: over 40 poses known to an eighth or so (120 numbers each).
TEST(ShownPoses, APersonGetsAboutThere) {
  Simulator world(reference_world(), 3);
  Random random(3, "shown poses");
  const auto wanted = calibration::candidate_poses(true_arm(world), reach_of(world.file()), 40, random,
                                                   world.truth().X_tip_marker.rotation);
  double places = 0.0, turns = 0.0;
  for (const auto& pose : wanted) {
    const device::PoseTarget target{calibration::predict_tip(true_arm(world), pose.joints),
                                    pose.marker->rotation};
    ASSERT_TRUE(world.person().ask({device::Gesture::next_pose, "", 0, target}));
    for (int ms = 0; ms < 3000 && !*world.person().ready(); ++ms)
      world.physics_clock().sleep_until(world.physics_clock().now() + seconds(0.001));
    const auto state = world.true_state();
    places += (state.X_world_tip.translation - target.tip.m).squaredNorm() / 40.0;
    turns += std::pow(angle_between(state.X_world_tip_marker.rotation, target.R_world_marker), 2) / 40.0;
  }
  // At the stops of the joints a miss outwards is cut off, so a little less than stated.
  EXPECT_GT(std::sqrt(places), 0.006);
  EXPECT_LT(std::sqrt(places), 0.013);
  EXPECT_GT(std::sqrt(turns), radians_from_degrees(3.7));
  EXPECT_LT(std::sqrt(turns), radians_from_degrees(6.3));
}

TEST(ShownPoses, FarOutOfReachIsRefusedAndTheRecordingGoesOn) {
  Simulator world(reference_world(), 3);
  const device::PoseTarget away{Point<World>{Vector3(5.0, 0.0, 0.0)}, Quaternion::Identity()};
  const auto asked = world.person().ask({device::Gesture::next_pose, "", 0, away});
  ASSERT_FALSE(asked);
  EXPECT_NE(asked.error().message.find("(5000, 0, 0) mm is out of the arm's reach"), std::string::npos);
  calibration::session::ArmRecordingOptions recording;
  recording.points = 4;
  int times = 0;
  recording.next =
      [&](const std::vector<calibration::session::TrackedPose>&) -> std::optional<device::PoseTarget> {
    if (++times % 2 == 0) return std::nullopt;
    return away;
  };
  const auto poses = calibration::session::record_arm(laboratory_of(world), recording);
  ASSERT_TRUE(poses) << poses.error().message;
  EXPECT_EQ(poses->size(), 4u);
}

// What a person chooses by themselves does not depend on what they were shown before.
TEST(ShownPoses, LeaveTheChoiceOfFreePosesAlone) {
  Simulator with(reference_world(), 4), without(reference_world(), 4);
  calibration::session::GuidedPoses guide(guidance_in(with.file()));
  ASSERT_TRUE(calibration::session::record_arm(laboratory_of(with), guide.recording(12)));
  ASSERT_TRUE(calibration::session::record_arm(laboratory_of(without), 8));
  const auto a = calibration::session::record_arm(laboratory_of(with), 3),
             b = calibration::session::record_arm(laboratory_of(without), 3);
  ASSERT_TRUE(a && b);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_LT(((*a)[i].joints - (*b)[i].joints).norm(), 2e-3) << i;  // the same place, reached another way
}

TEST(GuidedPosesStatistics, ThirtyAreAFifthBetterThanThirtyOfThePersonsOwnChoice) {
  for (const auto& file : {white_world(), reference_world()}) {
    std::vector<double> guided, free;
    for (std::uint64_t seed = 1; seed <= 7; ++seed) {
      Simulator world(file, seed), other(file, seed);
      auto options = guidance_in(file);
      options.seed = seed;
      calibration::session::GuidedPoses guide(options);
      const auto shown = calibration::session::record_arm(laboratory_of(world), guide.recording(30));
      ASSERT_TRUE(shown) << shown.error().message;
      guided.push_back(error_to_truth(*shown, world));
      const auto chosen = calibration::session::record_arm(laboratory_of(other), 30);
      ASSERT_TRUE(chosen) << chosen.error().message;
      free.push_back(error_to_truth(*chosen, other));
    }
    EXPECT_LT(median(guided), 0.8 * median(free)) << "bias " << file.tracker.bias_rms;
  }
}

TEST(GuidedPoses, TellAfterEachPoseHowGoodTheCalibrationIsByNow) {
  Simulator world(white_world(), 2);
  auto options = guidance_in(world.file());
  options.design.shared_sd = 0.0;  // white world
  std::vector<calibration::session::GuidanceState> told;
  options.report = [&told](const calibration::session::GuidanceState& state) { told.push_back(state); };
  calibration::session::GuidedPoses guide(options);
  const auto poses = calibration::session::record_arm(laboratory_of(world), guide.recording(30));
  ASSERT_TRUE(poses) << poses.error().message;
  ASSERT_EQ(told.size(), 30u);
  for (int i = 0; i < 30; ++i) {
    const auto& state = told[static_cast<std::size_t>(i)];
    EXPECT_EQ(state.poses, i + 1);
    EXPECT_EQ(std::isfinite(state.predicted_error), i >= 7) << i;  // eight before the first solve
    EXPECT_GT(state.coverage, 0.03);
    EXPECT_LE(state.coverage, 1.0);
    EXPECT_FALSE(state.worst_error < state.predicted_error);  // both not numbers at first
  }
  EXPECT_LT(told[29].predicted_error, 0.5 * told[7].predicted_error);
  EXPECT_GT(told[29].coverage, told[3].coverage);
  // The true error is one draw of what is predicted; eleven directions or so make it.
  const double real = error_to_truth(*poses, world);
  EXPECT_LT(real, 2.0 * told[29].predicted_error);
  EXPECT_GT(real, 0.3 * told[29].predicted_error);
  EXPECT_NE(calibration::session::guidance_text(told[29]).find("predicted error 0.0"), std::string::npos)
      << calibration::session::guidance_text(told[29]);
  EXPECT_NE(calibration::session::guidance_text(told[0]).find("% of the range visited"), std::string::npos);
}

TEST(GuidedPoses, AreTheSameForTheSameSeed) {
  std::vector<calibration::session::TrackedPose> runs[2];
  for (auto& run : runs) {
    Simulator world(reference_world(), 5);
    calibration::session::GuidedPoses guide(guidance_in(world.file()));
    const auto poses = calibration::session::record_arm(laboratory_of(world), guide.recording(16));
    ASSERT_TRUE(poses) << poses.error().message;
    run = *poses;
  }
  for (std::size_t i = 0; i < 16; ++i) {
    EXPECT_EQ(runs[0][i].joints, runs[1][i].joints);
    EXPECT_EQ(runs[0][i].marker.translation, runs[1][i].marker.translation);
  }
}

TEST(GuidedPoses, ACurveHasAValueAfterEachPoseAndFalls) {
  Simulator world(white_world(), 2);
  const auto poses = calibration::session::record_arm(laboratory_of(world), 20);
  ASSERT_TRUE(poses) << poses.error().message;
  const auto samples = calibration::session::arm_observations(*poses, world.file().tip_marker.tip);
  const auto reach = reach_of(world.file());
  const auto curve =
      calibration::session::predicted_error_curve(true_arm(world), samples, reach, {.shared_sd = 0.0});
  ASSERT_EQ(curve.size(), 20u);
  EXPECT_TRUE(std::isnan(curve[4]));
  for (std::size_t i = 6; i < 20; ++i) EXPECT_LE(curve[i], curve[i - 1] * (1.0 + 1e-9)) << i;
}

}  // namespace
}  // namespace palpate::evaluation
