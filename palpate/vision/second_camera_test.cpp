#include "palpate/vision/second_camera.h"

#include <gtest/gtest.h>

#include "palpate/vision/synthetic_room.h"
#include "tests/chi_square.h"

namespace palpate::vision {
namespace {

using namespace synthetic;

// What a second camera's session adds to landmarks that the first one's has left wrong by `off`.
constexpr Eigen::Index kPlacesFrom = device::kLensParameters + 6;

struct SecondSession {
  std::vector<rig::Landmark> truth, kept;
  rig::HandEyeCalibration true_hand_eye, hand_eye;
  rig::CameraCalibration camera;
  std::vector<LandmarkFrame> frames;
};

SecondSession second_session(const Eigen::VectorXd& off, const Eigen::MatrixXd& stated, std::uint64_t seed) {
  Random random(seed, "second camera");
  SecondSession s;
  s.truth = s.kept = dots();
  for (std::size_t i = 0; i < s.kept.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(i);
    s.kept[i].place.m += off.segment<3>(at);
    s.kept[i].covariance = stated.block<3, 3>(at, at);
  }
  s.true_hand_eye = s.hand_eye = hand_eye();
  s.hand_eye.covariance = diagonal(0.001, 0.0005);
  s.hand_eye.X_marker_camera = disturbed(s.hand_eye.X_marker_camera, draw(s.hand_eye.covariance, random));
  const Eigen::MatrixXd C_lens = board_lens_covariance();
  s.camera = {device::changed_lens(lens(), device::LensParameters(draw(C_lens, random))), C_lens};
  const Matrix6 tracker = diagonal(0.001, 0.0002);
  for (int f = 0; f < 50; ++f) {
    const auto X = camera_pose(0.2 * f);
    LandmarkFrame frame;
    frame.X_world_marker =
        disturbed(X * s.true_hand_eye.X_marker_camera.inverse(), Vector6(draw(tracker, random)));
    frame.covariance = tracker;
    frame.sightings = sightings(lens(), X, s.truth, 0.04, random);
    s.frames.push_back(frame);
  }
  return s;
}

LandmarkRefinementOptions second_options(double huber) {
  return {.pixel_sd = 0.04, .huber = huber, .shared_rotation_sd = 0.0, .shared_translation_sd = 0.0};
}

// Places known to a tenth of a millimetre as one body, and to a fiftieth each.
Eigen::MatrixXd kept_places_covariance(std::size_t count) {
  const auto n = 3 * static_cast<Eigen::Index>(count);
  Eigen::MatrixXd C = 4e-10 * Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i % 3; j < n; j += 3) C(i, j) += 1e-8;
  return C;
}

TEST(SecondCamera, IsWhatItsOwnSolveFindsWhereTheLandmarksAreHeld) {
  const std::size_t count = dots().size();
  const Eigen::MatrixXd C_LL = kept_places_covariance(count);
  Random random(5, "second camera landmarks");
  auto s = second_session(draw(C_LL, random), C_LL, 5);
  const auto own = refine_landmarks(s.camera, s.hand_eye, s.kept, s.frames, second_options(1e9));
  for (auto& landmark : s.kept) landmark.covariance = 1e-16 * Matrix3::Identity();
  const auto held = refine_landmarks(s.camera, s.hand_eye, s.kept, s.frames, second_options(1e9));
  ASSERT_TRUE(own && held);
  const auto n = own->covariance.rows();
  const auto second = fit_second_camera(*own, s.kept, Eigen::MatrixXd::Zero(n, n));
  const auto distance = [](const rig::HandEyeCalibration& a, const rig::HandEyeCalibration& b) {
    return error(a.X_marker_camera, b.X_marker_camera).norm();
  };
  // As good as the first derivative is; without it they lie a hundred times as far apart.
  EXPECT_LT(distance(second.hand_eye, held->value.hand_eye),
            0.02 * distance(own->value.hand_eye, held->value.hand_eye));
  EXPECT_LT(std::abs(second.camera.model.fx - held->value.camera.model.fx),
            0.02 * std::abs(own->value.camera.model.fx - held->value.camera.model.fx));
  const Eigen::MatrixXd stated = second.covariance.topLeftCorner(kPlacesFrom, kPlacesFrom),
                        expected = held->covariance.topLeftCorner(kPlacesFrom, kPlacesFrom);
  for (Eigen::Index i = 0; i < kPlacesFrom; ++i)
    EXPECT_NEAR(std::sqrt(stated(i, i)), std::sqrt(expected(i, i)), 0.02 * std::sqrt(expected(i, i))) << i;
}

TEST(SecondCameraStatistics, ItsErrorsAndTheKeptLandmarksAreStatedTogether) {
  const std::size_t count = dots().size();
  const Eigen::MatrixXd C_LL = kept_places_covariance(count);
  Eigen::MatrixXd kept = Eigen::MatrixXd::Zero(kPlacesFrom + C_LL.rows(), kPlacesFrom + C_LL.rows());
  kept.bottomRightCorner(C_LL.rows(), C_LL.rows()) = C_LL;
  double sum = 0.0;
  constexpr int kRuns = 100;
  for (std::uint64_t seed = 0; seed < kRuns; ++seed) {
    Random random(40 + seed, "second camera landmarks");
    const Eigen::VectorXd off = draw(C_LL, random);
    const auto s = second_session(off, C_LL, 80 + seed);
    const auto own = refine_landmarks(s.camera, s.hand_eye, s.kept, s.frames, second_options(2.0));
    ASSERT_TRUE(own) << own.error().message;
    const auto second = fit_second_camera(*own, s.kept, kept);
    Eigen::VectorXd e = Eigen::VectorXd::Zero(second.covariance.rows());
    const device::CameraModel truth = lens(), found = second.camera.model;
    e.head<4>() << found.fx - truth.fx, found.fy - truth.fy, found.cx - truth.cx, found.cy - truth.cy;
    for (std::size_t i = 0; i < 5; ++i)
      e[4 + static_cast<Eigen::Index>(i)] = found.distortion[i] - truth.distortion[i];
    e.segment<6>(device::kLensParameters) =
        -error(s.true_hand_eye.X_marker_camera, second.hand_eye.X_marker_camera);
    e.tail(off.size()) = off;
    sum += tests::normalised_square(e, second.covariance);
  }
  EXPECT_TRUE(tests::is_chi_square(sum, 51 * kRuns));
}

TEST(SecondCamera, LandmarksOfAnotherNumberAreAMistake) {
  const Eigen::MatrixXd C_LL = kept_places_covariance(dots().size());
  const auto s = second_session(Eigen::VectorXd::Zero(C_LL.rows()), C_LL, 3);
  const auto own = refine_landmarks(s.camera, s.hand_eye, s.kept, s.frames, second_options(2.0));
  ASSERT_TRUE(own);
  auto fewer = s.kept;
  fewer.pop_back();
  EXPECT_THROW(fit_second_camera(*own, fewer, own->covariance), std::invalid_argument);
  EXPECT_THROW(fit_second_camera(*own, s.kept, C_LL), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::vision
