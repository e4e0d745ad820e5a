#include "palpate/vision/pixel_hand_eye.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/random.h"
#include "palpate/core/units.h"
#include "palpate/device/pose_file.h"
#include "palpate/vision/camera.h"
#include "palpate/vision/synthetic_board.h"
#include "tests/chi_square.h"

namespace palpate::vision {
namespace {

const Pose<CameraMarker, CameraOptical> kX{so3_exp({0.3, -1.1, 0.4}), Vector3(0.05, -0.03, 0.08)};
const Pose<World, Board> kZ{so3_exp({-1.2, 0.4, 0.2}), Vector3(0.2, -0.6, -1.4)};

struct HandAndViews {
  std::vector<device::StampedPose> hand;
  std::vector<BoardView> views;
  std::vector<double> time_s;
};

device::CameraModel wide_lens() {
  device::CameraModel camera;
  camera.distortion = {-0.12, 0.05, 0.0008, -0.0005, 0.0};
  return camera;
}

struct MarkerErrors {
  double px = 0.2, turn = 2e-4, place = 2e-4;
};

device::StampedPose erring(const Pose<World, CameraMarker>& X, double t, const MarkerErrors& errors,
                           Random& random) {
  const Vector3 turn(random.normal(errors.turn), random.normal(errors.turn), random.normal(errors.turn)),
      shift(random.normal(errors.place), random.normal(errors.place), random.normal(errors.place));
  return {t, so3_exp(turn) * X.rotation, X.translation + shift};
}

// Views one by one, the head held still in each.
HandAndViews still(int count, Random& random, const MarkerErrors& errors = {}, double spread = 1.0,
                   const BoardShape& shape = {}) {
  HandAndViews recording;
  const auto first = synthetic::board_in_view(wide_lens(), shape, random);
  for (int i = 0; i < count; ++i) {
    auto X_camera_board = synthetic::board_in_view(wide_lens(), shape, random);
    X_camera_board = interpolate(first, X_camera_board, spread);
    recording.views.push_back(synthetic::view_of(wide_lens(), X_camera_board, shape, errors.px, random,
                                                 "view" + std::to_string(i)));
    recording.hand.push_back(erring(kZ * X_camera_board.inverse() * kX.inverse(), i, errors, random));
  }
  return recording;
}

// A head that moves slowly round, the hand's clock ahead by `delay`.
HandAndViews moving(int count, double delay, Random& random, const MarkerErrors& errors = {}) {
  HandAndViews recording;
  const BoardShape shape;
  const Vector3 middle = 0.5 * shape.corner(shape.corners() - 1);
  const auto at = [&](double t) {
    const Quaternion R = so3_exp({0.5 * std::sin(1.1 * t), 0.5 * std::cos(0.9 * t), 0.4 * std::sin(0.7 * t)});
    const Vector3 place(0.04 * std::sin(1.3 * t), 0.03 * std::cos(1.7 * t), 0.5 + 0.05 * std::sin(0.5 * t));
    return Pose<CameraOptical, Board>{R, place - R * middle};
  };
  for (double t = -1.0; t < 0.2 * count + 1.0; t += 0.01)
    recording.hand.push_back(erring(kZ * at(t).inverse() * kX.inverse(), t + delay, errors, random));
  for (int i = 0; i < count; ++i) {
    recording.time_s.push_back(0.2 * i);
    recording.views.push_back(
        synthetic::view_of(wide_lens(), at(0.2 * i), shape, errors.px, random, "view" + std::to_string(i)));
  }
  return recording;
}

Vector6 error_of(const PixelHandEye& found) {
  Vector6 e;
  e << so3_log(kX.rotation * found.X_marker_camera.rotation.conjugate()),
      kX.translation - found.X_marker_camera.translation;
  return e;
}

TEST(PixelHandEye, ExactViewsGiveTheTruth) {
  Random random(1);
  const auto recording = still(12, random, {0.0, 0.0, 0.0});
  const auto found = calibrate_hand_eye_pixels(recording.hand, recording.views, {}, wide_lens());
  ASSERT_TRUE(found.has_value()) << found.error().message;
  EXPECT_LT(error_of(found->value).norm(), 1e-7);
  EXPECT_LT(found->value.rms_px, 1e-4);
  EXPECT_TRUE(found->value.warnings.empty()) << found->value.warnings.front();
}

// MarkerErrors over stated deviations, squared, of many recordings.
double normalised_errors(int runs, int views, bool free_lens, double spread = 1.0) {
  double sum = 0.0;
  for (int run = 0; run < runs; ++run) {
    Random random(static_cast<std::uint64_t>(run), "views");
    const auto recording = still(views, random, {}, spread);
    auto start = wide_lens();
    if (free_lens) start.fx += 3.0, start.fy -= 2.0, start.distortion[0] += 0.01;
    const auto found =
        calibrate_hand_eye_pixels(recording.hand, recording.views, {}, start, {.free_lens = free_lens});
    EXPECT_TRUE(found.has_value());
    if (!found) continue;
    sum += tests::normalised_square(error_of(found->value), found->covariance.topLeftCorner(6, 6));
  }
  return sum;
}

TEST(PixelHandEye, StatesItsErrorWithTheLensGiven) {
  EXPECT_TRUE(tests::is_sum_of_f(normalised_errors(12, 15, false), 12, 6, 60))
      << normalised_errors(12, 15, false) / 72;
}
TEST(PixelHandEye, StatesItsErrorWithTheLensFree) {
  EXPECT_TRUE(tests::is_sum_of_f(normalised_errors(12, 15, true), 12, 6, 60))
      << normalised_errors(12, 15, true) / 72;
}

TEST(PixelHandEye, TenViewsOfLittleRotationSayHowLittleTheyKnow) {
  Random random(4);
  const auto recording = still(10, random, {}, 0.03);
  const auto found = calibrate_hand_eye_pixels(recording.hand, recording.views, {}, wide_lens());
  ASSERT_TRUE(found.has_value()) << found.error().message;
  const double sd = found->covariance.diagonal().segment<3>(3).cwiseSqrt().maxCoeff();
  EXPECT_GT(sd, 0.003);
  EXPECT_LT(error_of(found->value).tail<3>().norm(), 5.0 * sd);
  EXPECT_LT(normalised_errors(10, 10, false, 0.05) / 60, 2.5);
}

// A tracked endoscope, ten views of a board with a tracker's marker of its own; a peer's hand-eye from the same pictures.
class TrackedEndoscope : public testing::Test {
 protected:
  void SetUp() override {
    const std::string folder = std::string(PALPATE_DATA_DIR) + "/tracked_endoscope/";
    const auto hand = device::read_poses(folder + "hand.csv");
    const auto views = read_board_corners(folder + "corners.csv", {13, 8, 0.003});
    ASSERT_TRUE(hand && views);
    ASSERT_EQ(hand->poses.size(), 10u);
    ASSERT_EQ(views->views.size(), 10u);
    hand_ = hand->poses;
    views_ = views->views;
    const auto lens = calibrate_camera(views_, 1920, 1080);
    ASSERT_TRUE(lens) << lens.error().message;
    lens_ = lens->value.model;
  }
  Estimate<PixelHandEye> of_views(std::size_t begin, std::size_t end) const {
    const auto at = [](auto& all, std::size_t i) { return all.begin() + static_cast<std::ptrdiff_t>(i); };
    const auto found =
        calibrate_hand_eye_pixels({at(hand_, begin), at(hand_, end)}, {at(views_, begin), at(views_, end)},
                                  {}, lens_, {.free_lens = true});
    EXPECT_TRUE(found) << found.error().message;
    return found ? *found : Estimate<PixelHandEye>{};
  }
  std::vector<device::StampedPose> hand_;
  std::vector<BoardView> views_;
  device::CameraModel lens_;
};

TEST_F(TrackedEndoscope, LiesWhereThePeerFindsItAndSaysHowLittleThatIsKnown) {
  const Vector3 peers(-18.59e-3, 201.24e-3, -195.14e-3);  // calib.left.handeye.txt, turned round
  const auto found = of_views(0, 10);
  const Vector3 sd = found.covariance.diagonal().segment<3>(3).cwiseSqrt();
  const Vector3 off = found.value.X_marker_camera.translation - peers;
  EXPECT_LT((off.array() / sd.array()).abs().maxCoeff(), 4.0) << off.transpose() * 1e3;
  EXPECT_GT(sd.minCoeff(), 0.5e-3);
  EXPECT_LT(sd.maxCoeff(), 5e-3);
  EXPECT_LT(found.value.noise_px, 0.6);
}

TEST_F(TrackedEndoscope, HalvesOfTheViewsAgreeWithinWhatTheyState) {
  const auto first = of_views(0, 5), second = of_views(5, 10);
  const Matrix6 sum = first.covariance.topLeftCorner<6, 6>() + second.covariance.topLeftCorner<6, 6>();
  Vector6 off;
  off << so3_log(first.value.X_marker_camera.rotation * second.value.X_marker_camera.rotation.conjugate()),
      first.value.X_marker_camera.translation - second.value.X_marker_camera.translation;
  EXPECT_LT(off.dot(sum.ldlt().solve(off)), 22.5);  // chi-squared of six, one in 1000
}

TEST(PixelHandEye, FindsTheDelayAndNamesAForgottenOne) {
  Random random(5);
  const auto recording = moving(60, 0.03, random);
  const auto found = calibrate_hand_eye_pixels(recording.hand, recording.views, recording.time_s, wide_lens(),
                                               {.free_delay = true});
  ASSERT_TRUE(found.has_value()) << found.error().message;
  EXPECT_NEAR(found->value.delay_s, 0.03, 4.0 * found->standard_deviation(12));
  EXPECT_LT(found->standard_deviation(12), 1e-3);
  EXPECT_TRUE(found->value.warnings.empty()) << found->value.warnings.front();
  const auto forgotten =
      calibrate_hand_eye_pixels(recording.hand, recording.views, recording.time_s, wide_lens());
  ASSERT_TRUE(forgotten.has_value()) << forgotten.error().message;
  ASSERT_FALSE(forgotten->value.warnings.empty());
  EXPECT_NE(forgotten->value.warnings[0].find("--estimate-delay"), std::string::npos);
  EXPECT_NEAR(forgotten->value.untold_delay_s, 0.03, 2e-3);
}

TEST(PixelHandEye, NamesAWrongSizeOfTheSquares) {
  Random random(6);
  auto recording = still(15, random);
  for (auto& view : recording.views)
    for (auto& corner : view.board) corner *= 1.2;
  const auto found = calibrate_hand_eye_pixels(recording.hand, recording.views, {}, wide_lens());
  ASSERT_TRUE(found.has_value()) << found.error().message;
  ASSERT_FALSE(found->value.warnings.empty());
  EXPECT_NE(found->value.warnings[0].find("--square-mm"), std::string::npos);
  EXPECT_NEAR(found->value.board_scale, 1.0 / 1.2, 0.01);
}

TEST(PixelHandEye, NamesHandPosesThatAreTheOtherWayRound) {
  Random random(7);
  auto recording = still(15, random);
  for (auto& pose : recording.hand) {
    const auto inverse = pose.as<World, CameraMarker>().inverse();
    pose.rotation = inverse.rotation, pose.translation = inverse.translation;
  }
  const auto found = calibrate_hand_eye_pixels(recording.hand, recording.views, {}, wide_lens());
  ASSERT_FALSE(found.has_value());
  EXPECT_NE(found.error().message.find("other way round"), std::string::npos);
}

TEST(PixelHandEye, ABlunderAmongTheHandPosesIsNamedAndHardlyCounts) {
  Random random(8);
  auto recording = still(20, random);
  recording.hand[7].translation.x() += 0.05;
  const auto found = calibrate_hand_eye_pixels(recording.hand, recording.views, {}, wide_lens());
  ASSERT_TRUE(found.has_value()) << found.error().message;
  EXPECT_LT(error_of(found->value).tail<3>().norm(), 0.001);
  ASSERT_FALSE(found->value.warnings.empty());
  EXPECT_NE(found->value.warnings[0].find("view7"), std::string::npos);
}

}  // namespace
}  // namespace palpate::vision
