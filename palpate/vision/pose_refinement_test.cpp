#include "palpate/vision/pose_refinement.h"

#include <gtest/gtest.h>

#include "palpate/vision/synthetic_room.h"
#include "tests/chi_square.h"

namespace palpate::vision {
namespace {

using namespace synthetic;

// rms distance in the undistorted picture between what the pose draws and what is there, over a grid on table
// and wall.
double overlay_px(const device::CameraModel& camera, const Pose<World, CameraOptical>& truth,
                  const Pose<World, CameraOptical>& drawn) {
  double sum = 0.0;
  int n = 0;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      for (const Vector3& p : {Vector3(-0.3 + 0.12 * i, -1.52, 0.9 + 0.15 * j),
                               Vector3(-0.3 + 0.12 * i, -1.45 + 0.1 * j, 0.8)}) {
        const device::Pixel a = camera.project_undistorted((truth.inverse() * Point<World>{p}).m);
        const device::Pixel b = camera.project_undistorted((drawn.inverse() * Point<World>{p}).m);
        sum += (a - b).squaredNorm(), ++n;
      }
  return std::sqrt(sum / n);
}

TEST(PoseRefinement, PerfectSightingsGiveTheTruePose) {
  const auto camera = lens();
  const auto landmarks = dots();
  Random random(1, "pose refinement");
  for (int k = 0; k < 20; ++k) {
    const auto truth = camera_pose(k);
    const CameraPosePrior prior{disturbed(truth, draw(diagonal(0.01, 0.01), random)), diagonal(0.01, 0.01)};
    const auto pose = refine_camera_pose(
        camera, prior, landmarks, sightings(camera, truth, landmarks, 0.0, random), {.pixel_sd = 1e-5});
    ASSERT_TRUE(pose.refined);
    EXPECT_GE(pose.inliers, 8);
    EXPECT_LT(error(truth, pose.X_world_camera).norm(),
              1e-7);  // the prior, a thousand pixel deviations off, still pulls a little
  }
}

TEST(PoseRefinement, ErrorsAgreeWithTheCovarianceItClaims) {
  const auto camera = lens();
  Random random(2, "pose refinement");
  const auto P = diagonal(0.002, 0.0003);
  double sum = 0.0;
  constexpr int kRuns = 1000;
  for (int k = 0; k < kRuns; ++k) {
    auto known = dots();
    const auto true_dots = known;
    for (auto& dot : known) {
      dot.covariance = 0.0003 * 0.0003 * Matrix3::Identity();
      dot.place.m += normal3(random, 0.0003);
    }
    const auto truth = camera_pose(0.1 * k);
    const CameraPosePrior prior{disturbed(truth, draw(P, random)), P};
    const auto pose =
        refine_camera_pose(camera, prior, known, sightings(camera, truth, true_dots, 0.1, random));
    ASSERT_TRUE(pose.refined);
    const Vector6 e = error(truth, pose.X_world_camera);
    sum += tests::normalised_square(e, pose.covariance);
  }
  // Huber's loss costs an honest sighting in eight a little of its pull, which the covariance, told with the weights,
  // allows for.
  EXPECT_TRUE(tests::is_chi_square(sum, 6 * kRuns));
}

TEST(PoseRefinement, OverlayFallsWellBelowThatOfTheTracker) {
  const auto camera = lens();
  const auto landmarks = dots();
  Random random(3, "pose refinement");
  const auto P = diagonal(0.002, 0.0003);
  double before = 0.0, after = 0.0;
  for (int k = 0; k < 100; ++k) {
    const auto truth = camera_pose(0.3 * k);
    const CameraPosePrior prior{disturbed(truth, draw(P, random)), P};
    const auto pose =
        refine_camera_pose(camera, prior, landmarks, sightings(camera, truth, landmarks, 0.1, random));
    before += std::pow(overlay_px(camera, truth, prior.X_world_camera), 2) / 100;
    after += std::pow(overlay_px(camera, truth, pose.X_world_camera), 2) / 100;
  }
  EXPECT_GT(std::sqrt(before), 1.0);
  EXPECT_LT(std::sqrt(after), 0.12);  // 0.1 px on a dozen dots, read off between and beside them
}

TEST(PoseRefinement, FalseSightingsDoNotPull) {
  const auto camera = lens();
  const auto landmarks = dots();
  Random random(4, "pose refinement");
  const auto truth = camera_pose(1.0);
  const auto P = diagonal(0.002, 0.0003);
  const CameraPosePrior prior{disturbed(truth, draw(P, random)), P};
  auto seen = sightings(camera, truth, landmarks, 0.1, random);
  const auto clean = refine_camera_pose(camera, prior, landmarks, seen);
  seen[0].centre += device::Pixel(12, -5);
  std::swap(seen[3].landmark, seen[4].landmark);
  const auto pose = refine_camera_pose(camera, prior, landmarks, seen);
  EXPECT_TRUE(pose.refined);
  EXPECT_EQ(pose.inliers, static_cast<int>(seen.size()) - 3);
  EXPECT_LT(overlay_px(camera, truth, pose.X_world_camera),
            2.0 * overlay_px(camera, truth, clean.X_world_camera) + 0.05);
}

TEST(PoseRefinement, AThirdOfTheLandmarksMovedByACentimetreIsFoundOut) {
  const auto camera = lens();
  const auto landmarks = dots();
  Random random(7, "pose refinement");
  const auto P = diagonal(0.002, 0.0003);
  double squares = 0.0;
  constexpr int kRuns = 200;
  for (int k = 0; k < kRuns; ++k) {
    auto moved = landmarks;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::size_t which = (static_cast<std::size_t>(k) + 3 * i) % moved.size();
      const double angle = random.uniform(0.0, 6.28);
      const Vector3 along = moved[which].normal.unitOrthogonal();
      moved[which].place.m += 0.01 * (Quaternion(Eigen::AngleAxisd(angle, moved[which].normal)) * along);
    }
    const auto truth = camera_pose(0.2 * k);
    const CameraPosePrior prior{disturbed(truth, draw(P, random)), P};
    const auto seen = sightings(camera, truth, moved, 0.1, random);
    const auto pose = refine_camera_pose(camera, prior, landmarks, seen);
    ASSERT_TRUE(pose.refined) << k;
    EXPECT_GE(pose.outliers, 3) << k;
    EXPECT_EQ(pose.inliers + pose.outliers, static_cast<int>(seen.size()));
    squares += std::pow(overlay_px(camera, truth, pose.X_world_camera), 2);
  }
  EXPECT_LT(std::sqrt(squares / kRuns), 0.2);  // eight good ones instead of twelve: 0.12 px times 1.5
}

// Wrong matches that agree with each other, as when a row of dots is taken for its neighbour, pull the fit
// towards themselves until true sightings lie beyond the limit as well. Whoever drops all of these at once is
// left with the prior, which fits nothing either.
TEST(PoseRefinement, WrongMatchesThatAgreeWithEachOtherAreLeftOneByOne) {
  const auto camera = lens();
  const auto landmarks = dots();
  Random random(10, "pose refinement");
  const auto P = diagonal(0.002, 0.0003);
  int refined = 0;
  double squares = 0.0;
  constexpr int kRuns = 200;
  for (int k = 0; k < kRuns; ++k) {
    const auto truth = camera_pose(0.2 * k);
    const CameraPosePrior prior{disturbed(truth, draw(P, random)), P};
    auto seen = sightings(camera, truth, landmarks, 0.05, random);
    const double angle = random.uniform(0.0, 6.28);
    for (std::size_t i = 0; i < 4 && i < seen.size(); ++i)
      seen[(static_cast<std::size_t>(k) + 2 * i) % seen.size()].centre +=
          7.0 * device::Pixel(std::cos(angle), std::sin(angle)) +
          device::Pixel(random.normal(0.5), random.normal(0.5));
    const auto pose = refine_camera_pose(camera, prior, landmarks, seen, {.pixel_sd = 0.05});
    if (!pose.refined || pose.outliers != 4) continue;
    ++refined;
    squares += std::pow(overlay_px(camera, truth, pose.X_world_camera), 2);
  }
  EXPECT_GE(refined, 195);  // dropped all at once: 166
  EXPECT_LT(std::sqrt(squares / refined), 0.1);
}

TEST(PoseRefinement, WhereMostSightingsDisagreeThePriorStays) {
  const auto camera = lens();
  const auto landmarks = dots();
  Random random(8, "pose refinement");
  const auto truth = camera_pose(1.0);
  const auto P = diagonal(0.002, 0.0003);
  const CameraPosePrior prior{disturbed(truth, draw(P, random)), P};
  auto seen = sightings(camera, truth, landmarks, 0.1, random);
  for (std::size_t i = 0; i + 4 < seen.size(); ++i)
    seen[i].centre += device::Pixel(random.uniform(-25, 25), random.uniform(-25, 25));
  const auto pose = refine_camera_pose(camera, prior, landmarks, seen);
  EXPECT_FALSE(pose.refined);
  EXPECT_EQ(pose.X_world_camera.translation, prior.X_world_camera.translation);
}

TEST(PoseRefinement, AnUncertainSightingPullsAsMuchAsItSays) {
  const auto camera = lens();
  const auto landmarks = dots();
  Random random(9, "pose refinement");
  const auto truth = camera_pose(0.5);
  const auto P = diagonal(0.002, 0.0003);
  const CameraPosePrior prior{disturbed(truth, draw(P, random)), P};
  auto seen = sightings(camera, truth, landmarks, 0.05, random);
  const auto before = refine_camera_pose(camera, prior, landmarks, seen, {.pixel_sd = 0.05});
  seen[0].centre += device::Pixel(1.5, 0);
  seen[0].covariance = 2.0 * Eigen::Matrix2d::Identity();  // and it says so
  const auto after = refine_camera_pose(camera, prior, landmarks, seen, {.pixel_sd = 0.05});
  EXPECT_EQ(after.inliers, static_cast<int>(seen.size()));
  EXPECT_LT(overlay_px(camera, before.X_world_camera, after.X_world_camera), 0.02);
}

TEST(PoseRefinement, TwoSightingsLeaveThePriorAsItIs) {
  const auto camera = lens();
  const auto landmarks = dots();
  Random random(5, "pose refinement");
  const auto truth = camera_pose(2.0);
  const CameraPosePrior prior{disturbed(truth, draw(diagonal(0.002, 0.0003), random)),
                              diagonal(0.002, 0.0003)};
  auto seen = sightings(camera, truth, landmarks, 0.1, random);
  seen.resize(2);
  const auto pose = refine_camera_pose(camera, prior, landmarks, seen);
  EXPECT_FALSE(pose.refined);
  EXPECT_EQ(pose.X_world_camera.translation, prior.X_world_camera.translation);
  EXPECT_EQ(pose.covariance, prior.covariance);
  EXPECT_FALSE(refine_camera_pose(camera, prior, landmarks, {}).refined);
}

TEST(PoseRefinement, PriorOfMarkerAndHandEyeCarriesBothUncertainties) {
  const auto hand = hand_eye();
  const Pose<World, CameraMarker> M{so3_exp(Vector3(0.3, -0.5, 0.2)), Vector3(0.1, -0.9, 2.3)};
  Random random(6, "pose refinement");
  Matrix6 Cm, Ch;
  for (auto* C : {&Cm, &Ch}) {
    Matrix6 a;
    for (int i = 0; i < 36; ++i) a.data()[i] = 1e-3 * random.normal();
    *C = a * a.transpose();
  }
  rig::HandEyeCalibration uncertain = hand;
  uncertain.covariance = Ch;
  const auto prior = camera_from_marker(M, Cm, uncertain);
  EXPECT_NEAR((prior.X_world_camera.translation - (M * hand.X_marker_camera).translation).norm(), 0.0, 1e-15);
  // by brute force: numeric derivatives of the composed pose
  Eigen::Matrix<double, 6, 12> J;
  for (int i = 0; i < 12; ++i) {
    Vector6 d = Vector6::Zero();
    d(i % 6) = 1e-6;
    const auto plus = i < 6 ? disturbed(M, d) * hand.X_marker_camera : M * disturbed(hand.X_marker_camera, d);
    J.col(i) = error(plus, prior.X_world_camera) / 1e-6;
  }
  const Matrix6 expected = J.leftCols<6>() * Cm * J.leftCols<6>().transpose() +
                           J.rightCols<6>() * Ch * J.rightCols<6>().transpose();
  EXPECT_LT((prior.covariance - expected).norm(), 1e-5 * expected.norm());  // forward differences
}

}  // namespace
}  // namespace palpate::vision
