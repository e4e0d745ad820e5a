#include "palpate/calibration/pivot.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <filesystem>

#include "palpate/calibration/absolute_orientation.h"
#include "palpate/device/point_file.h"
#include "palpate/device/pose_file.h"
#include "palpate/math/random_vector.h"
#include "tests/chi_square.h"

namespace palpate::calibration {
namespace {

const Vector3 kTip(0.004, -0.018, -0.118);

struct Motion {
  int segments = 1, poses = 100;
  double swing = 0.4;        // rad, sd of the marker's turn about each axis
  double place_noise = 0.0;  // m
  bool one_axis = false;
};

std::vector<PivotPose> swing(Random& random, const Motion& motion) {
  std::vector<PivotPose> poses;
  for (int s = 0; s < motion.segments; ++s) {
    const Vector3 pivot = normal3(random, 0.3);
    const Quaternion mean = so3_exp(normal3(random));
    for (int i = 0; i < motion.poses; ++i) {
      const Vector3 turn =
          motion.one_axis ? Vector3(random.normal(motion.swing), 0, 0) : normal3(random, motion.swing);
      PivotPose pose{mean * so3_exp(turn), Vector3::Zero(), s, std::nullopt};
      pose.translation = pivot - pose.rotation * kTip + normal3(random, motion.place_noise);
      poses.push_back(pose);
    }
  }
  return poses;
}

double tip_error(const Expected<Estimate<PivotSolution>>& estimate) {
  EXPECT_TRUE(estimate.has_value()) << estimate.error().message;
  return estimate ? (estimate->value.tip - kTip).norm() : 1.0;
}

TEST(Pivot, ExactPosesGiveTheExactTipByEveryMethod) {
  Random random(1);
  const auto poses = swing(random, {.segments = 3, .poses = 30});
  for (auto method : {PivotMethod::algebraic, PivotMethod::robust, PivotMethod::sphere})
    EXPECT_LT(tip_error(calibrate_pivot(poses, {.method = method})), 1e-13);
}

TEST(Pivot, AGivenTipLeavesOnlyThePivots) {
  Random random(2);
  const auto poses = swing(random, {.segments = 2, .poses = 10, .swing = 0.01});
  const auto estimate = calibrate_pivot(poses, {.given_tip = kTip});
  ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
  const Vector3 pivot = poses[0].rotation * kTip + poses[0].translation;
  EXPECT_NEAR((estimate->value.segments[0].pivot - pivot).norm(), 0.0, 1e-14);
  EXPECT_EQ(estimate->covariance.topLeftCorner(3, 3).norm(), 0.0);
}

// White noise on the marker's place. The correlation factor only ever enlarges the covariance, by a few per cent
// here.
TEST(PivotStatistics, ErrorsAgreeWithTheCovariance) {
  Random random(3);
  for (auto method : {PivotMethod::algebraic, PivotMethod::robust, PivotMethod::sphere}) {
    double sum = 0.0;
    constexpr int kRuns = 1000;
    for (int run = 0; run < kRuns; ++run) {
      const auto poses = swing(random, {.segments = 2, .poses = 60, .place_noise = 2e-4});
      const auto estimate = calibrate_pivot(poses, {.method = method});
      ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
      const Vector3 error = estimate->value.tip - kTip;
      const Matrix3 C = estimate->covariance.topLeftCorner<3, 3>();
      sum += tests::normalised_square(error, C);
    }
    EXPECT_TRUE(tests::is_sum_of_f(sum, kRuns, 3, 351)) << static_cast<int>(method);
  }
}

TEST(Pivot, CorrelatedErrorsWidenTheCovariance) {
  Random random(4);
  auto poses = swing(random, {.poses = 400});
  Vector3 drift = Vector3::Zero();  // first-order process with correlation length 20 samples
  for (auto& pose : poses) {
    drift = 0.95 * drift + normal3(random, 1e-4);
    pose.translation += drift;
  }
  const auto estimate = calibrate_pivot(poses);
  ASSERT_TRUE(estimate.has_value());
  EXPECT_GT(estimate->value.correlation, 10.0);  // (1 + 0.95) / (1 - 0.95) = 39 for an endless record
}

TEST(Pivot, RobustMethodIgnoresOutliersAndNamesThem) {
  Random random(5);
  auto poses = swing(random, {.poses = 200, .place_noise = 2e-4});
  for (std::size_t i = 0; i < poses.size(); i += 10) poses[i].translation += normal3(random, 0.02);
  const auto robust = calibrate_pivot(poses, {.method = PivotMethod::robust});
  const auto plain = calibrate_pivot(poses);
  EXPECT_LT(tip_error(robust), 2e-4);
  EXPECT_GT(tip_error(plain), 3.0 * tip_error(robust));
  EXPECT_FALSE(robust->inlier[0]);
  EXPECT_GE(std::count(robust->inlier.begin(), robust->inlier.end(), true), 178);
}

// The tip is dragged by 1-2 mm in a direction that turns with the marker: the biased tip of a soft fixation.
TEST(Pivot, TheArmsReadingsRemoveTheTipsOwnMotion) {
  Random random(6);
  auto poses = swing(random, {.poses = 300, .place_noise = 2e-4});
  const Quaternion R_world_arm = so3_exp(Vector3(0.3, -1.2, 0.5));
  for (auto& pose : poses) {
    const Vector3 dragged = pose.rotation * Vector3(0, 0, 0.0015) + normal3(random, 3e-4);
    pose.translation += dragged;
    pose.motion = Vector3(0.1, 0.2, 0.3) + R_world_arm.conjugate() * dragged;
  }
  const auto with = calibrate_pivot(poses, {.with_motion = true});
  EXPECT_GT(tip_error(calibrate_pivot(poses)), 1e-3);
  EXPECT_LT(tip_error(with), 2e-4);
  EXPECT_LT(angle_between(with->value.R_world_arm, R_world_arm), 0.1);
}

// The reading beside a pose is what the arm saw 15 ms later.
TEST(Pivot, AConstantDelayOfTheArmIsFound) {
  Random random(9);
  const auto turn = [](double t) {
    return Vector3(0.5 * std::sin(3.1 * t), 0.5 * std::sin(2.3 * t + 1), 0.3 * std::sin(1.3 * t));
  };
  const auto dragged = [&](double t) {
    return Vector3(so3_exp(turn(t)) * Vector3(2e-4, 0, 0.0015) +
                   8e-4 * Vector3(std::sin(1.7 * t), std::cos(2.9 * t), std::sin(4.1 * t)));
  };
  std::vector<PivotPose> poses;
  for (int i = 0; i < 400; ++i) {
    const double t = 0.03 * i;
    PivotPose pose{so3_exp(turn(t)), Vector3::Zero(), 0, dragged(t + 0.015), t};
    pose.translation = dragged(t) - pose.rotation * kTip + normal3(random, 1e-5);
    poses.push_back(pose);
  }
  const auto with = calibrate_pivot(poses, {.with_motion = true});
  EXPECT_LT(tip_error(with), 5e-6);
  EXPECT_NEAR(with->value.delay, -0.015, 0.0005);
  for (auto& pose : poses) pose.time_s.reset();
  EXPECT_GT(tip_error(calibrate_pivot(poses, {.with_motion = true})), 2.0 * tip_error(with));
}

// A bias of the tracker that changes smoothly with the marker's place, besides white noise: the stated 95 %
// region holds the tip; that of the autocorrelation alone would not.
TEST(PivotStatistics, ASmoothBiasIsInTheCovariance) {
  int inside = 0, inside_before = 0;
  double stated = 0.0, error = 0.0;
  constexpr int kRuns = 200;
  for (int run = 0; run < kRuns; ++run) {
    Random random(static_cast<std::uint64_t>(run), "pivot bias");
    auto poses = swing(random, {.poses = 150, .place_noise = 1e-4});
    std::vector<std::array<Vector3, 2>> waves;
    std::vector<double> phases;
    for (int w = 0; w < 24; ++w) {
      waves.push_back({normal3(random, 1.0 / 0.15), normal3(random, 1e-4 * std::sqrt(2.0 / 24.0))});
      phases.push_back(random.uniform(0.0, 6.28));
    }
    for (auto& pose : poses) {
      Vector3 bias = Vector3::Zero();
      for (std::size_t w = 0; w < waves.size(); ++w)
        bias += std::cos(waves[w][0].dot(pose.translation) + phases[w]) * waves[w][1];
      pose.translation += bias;
    }
    const auto plain = calibrate_pivot(poses), shared = calibrate_pivot(poses, {.shared_errors = true});
    ASSERT_TRUE(plain && shared);
    EXPECT_EQ(plain->value.tip, shared->value.tip);
    const Vector3 off = shared->value.tip - kTip;
    const auto holds = [&](const auto& estimate) {
      const Matrix3 C = estimate->covariance.template topLeftCorner<3, 3>();
      return tests::normalised_square(off, C) < tests::chi_square_quantile(0.05, 3, true);
    };
    inside += holds(shared), inside_before += holds(plain);
    stated += shared->covariance.topLeftCorner<3, 3>().trace(), error += off.squaredNorm();
  }
  const auto honest = tests::binomial_bracket(kRuns, 0.95);
  EXPECT_GE(inside, honest.low);
  EXPECT_LT(inside_before, honest.low);
  EXPECT_LT(stated,
            9.0 * error);  // three times as wide as the errors at most: one recording tells little of a field
}

TEST(Pivot, TheBootstrapIsTheSameForASeedAndLongerBlocksForSlowerErrors) {
  Random random(10);
  auto poses = swing(random, {.segments = 2, .poses = 150, .place_noise = 2e-4});
  const auto a = calibrate_pivot(poses, {.shared_errors = true, .seed = 3}),
             b = calibrate_pivot(poses, {.shared_errors = true, .seed = 3}),
             c = calibrate_pivot(poses, {.shared_errors = true, .seed = 4});
  ASSERT_TRUE(a && b && c);
  EXPECT_EQ(a->value.bootstrap_std, b->value.bootstrap_std);
  EXPECT_NE(a->value.bootstrap_std, c->value.bootstrap_std);
  // white noise: the bootstrap scatters as the formal covariance says, 200 draws to 5 %
  const auto formal = calibrate_pivot(poses);
  EXPECT_NEAR(a->value.bootstrap_std.norm() / std::sqrt(formal->covariance.topLeftCorner<3, 3>().trace()),
              1.0, 0.2);
  Vector3 drift = Vector3::Zero();
  for (auto& pose : poses) {
    drift = 0.9 * drift + normal3(random, 2e-4);
    pose.translation += drift;
  }
  const auto slow = calibrate_pivot(poses, {.shared_errors = true});
  ASSERT_TRUE(slow);
  EXPECT_GT(slow->value.bootstrap_block, 2 * a->value.bootstrap_block);
  EXPECT_GE(slow->value.bootstrap_block, 19);  // a correlation time of (1 + 0.9) / (1 - 0.9) samples
}

TEST(Pivot, MotionThatIsNotSubtractedIsToldAndCounted) {
  Random random(6);
  auto poses = swing(random, {.poses = 200, .place_noise = 2e-4});
  for (auto& pose : poses) {
    const Vector3 dragged = pose.rotation * Vector3(0, 0, 0.0015) + normal3(random, 3e-4);
    pose.translation += dragged;
    pose.motion = dragged;
  }
  const auto without = calibrate_pivot(poses, {.shared_errors = true});
  ASSERT_TRUE(without);
  ASSERT_TRUE(without->value.tip_shift.has_value());
  EXPECT_NEAR(without->value.tip_shift->z(), 0.0015, 2e-4);
  EXPECT_LT(std::abs(without->value.tip.z() - kTip.z()), 2.0 * without->standard_deviation(2));
}

TEST(Pivot, TooLittleMotionIsRefusedWithFigures) {
  Random random(7);
  const auto refusal = [](const std::vector<PivotPose>& poses) {
    const auto estimate = calibrate_pivot(poses);
    return estimate ? std::string("none") : estimate.error().message;
  };
  EXPECT_NE(refusal(swing(random, {.poses = 3})).find("3 poses; at least 4"), std::string::npos);
  EXPECT_NE(refusal(swing(random, {.swing = 0.01})).find("at least 10 deg are needed"), std::string::npos);
  EXPECT_NE(refusal(swing(random, {.place_noise = 2e-4, .one_axis = true})).find("about one axis only"),
            std::string::npos);
  auto broken = swing(random, {});
  broken[5].translation.x() = std::nan("");
  EXPECT_NE(refusal(broken).find("pose 6 is not finite"), std::string::npos);
  EXPECT_FALSE(
      calibrate_pivot(swing(random, {.place_noise = 2e-4, .one_axis = true}), {.method = PivotMethod::sphere})
          .has_value());
}

// A real recording; reference figures from numpy (data/plus_eight_landmark_pivots/ORIGIN.md).
class RealPivots : public testing::Test {
 protected:
  void SetUp() override {
    const auto file = device::read_poses(folder / "stylus_to_reference.csv", {.segment_column = "landmark"});
    ASSERT_TRUE(file.has_value()) << file.error().message;
    for (const auto& pose : file->poses)
      poses.push_back({pose.rotation, pose.translation, pose.segment, std::nullopt});
  }
  const std::filesystem::path folder = std::filesystem::path(PALPATE_DATA_DIR) / "plus_eight_landmark_pivots";
  std::vector<PivotPose> poses;
};

TEST_F(RealPivots, EightSegmentsGiveOneTip) {
  const auto estimate = calibrate_pivot(poses);
  ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
  // the recording's matrices are rotations to 1e-5 only; the reference used them as they are
  EXPECT_LT((1e3 * estimate->value.tip - Vector3(109.6255, 6.6077, 2.7924)).norm(), 0.05);
  ASSERT_EQ(estimate->value.segments.size(), 8u);
  EXPECT_NEAR(1e3 * rms_per_component(estimate->residuals), 0.2922, 0.003);
  EXPECT_NEAR(1e3 * estimate->value.segments[4].own_tip.value().x(), 109.6776, 0.05);
  // formal errors alone would say 0.03 mm; the segments scatter by ten times as much
  EXPECT_GT(1e3 * estimate->standard_deviation(0), 0.08);
}

TEST_F(RealPivots, StatedDeviationsCoverTheScatterBetweenSegments) {
  for (const auto method : {PivotMethod::algebraic, PivotMethod::robust}) {
    const auto estimate = calibrate_pivot(poses, {.method = method, .shared_errors = true});
    ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
    const auto& s = estimate->value;
    int inside = 0;
    for (const auto& segment : s.segments) {
      ASSERT_TRUE(segment.own_tip && segment.own_covariance);
      const Vector3 off = *segment.own_tip - s.tip;
      inside +=
          tests::normalised_square(off, *segment.own_covariance) < tests::chi_square_quantile(0.05, 3, true);
    }
    EXPECT_EQ(inside, 8);
    for (Eigen::Index i = 0; i < 3; ++i) {
      EXPECT_GT(estimate->standard_deviation(i), std::sqrt(s.tip_scatter(i, i) / 8.0)) << i;
      EXPECT_LT(estimate->standard_deviation(i), 0.001) << i;  // and yet says something
    }
  }
}

TEST_F(RealPivots, LandmarksGiveThePhantomsPose) {
  const auto estimate = calibrate_pivot(poses, {.given_tip = Vector3(0.108565, 0.00777385, 0.0025389)});
  ASSERT_TRUE(estimate.has_value()) << estimate.error().message;
  const auto landmarks = device::read_points(folder / "landmarks_phantom.csv");
  ASSERT_TRUE(landmarks.has_value()) << landmarks.error().message;
  std::vector<Vector3> pivots;
  for (const auto& segment : estimate->value.segments) pivots.push_back(segment.pivot);
  const auto fit = absolute_orientation(landmarks->points, pivots);
  ASSERT_TRUE(fit.has_value()) << fit.error().message;
  Matrix3 peer;
  peer << -0.00479115, 0.00329566, -0.999983, -0.0127965, 0.999912, 0.00335674, 0.999907, 0.0128124,
      -0.00474856;
  EXPECT_LT((1e3 * fit->value.translation - Vector3(22.7064, -39.7536, 25.6504)).norm(), 0.35);
  EXPECT_LT(angle_between(Quaternion(fit->value.rotation), Quaternion(peer)), 0.0035);  // 0.2 deg
  EXPECT_NEAR(1e3 * mean_norm(fit->residuals), 0.262, 0.005);
}

// The fourth marker slipped: its poses are outliers, all of them, and its pivot would have no weight at all.
TEST(Pivot, PosesOfNoRestingTipAreRefusedWithTheLikelyReason) {
  Random random(9);
  const auto good = swing(random, {.segments = 1, .poses = 200, .place_noise = 0.002});
  EXPECT_TRUE(calibrate_pivot(good));  // a tip that slips by 2 mm per axis is a tip
  auto metres = good, turned = good, inverse = good;
  for (auto& pose : metres) pose.translation *= 1000.0;
  for (auto& pose : turned) {  // w read as the last number
    const Quaternion q = pose.rotation;
    pose.rotation = Quaternion(q.x(), q.y(), q.z(), q.w());
  }
  for (auto& pose : inverse) pose.rotation = pose.rotation.conjugate();
  auto two = swing(random, {.segments = 2, .poses = 100});
  for (auto& pose : two) pose.segment = 0;
  for (const auto method : {PivotMethod::algebraic, PivotMethod::sphere}) {
    const auto refusal = [&](const std::vector<PivotPose>& poses) {
      const auto estimate = calibrate_pivot(poses, {.method = method});
      return estimate ? std::string("none") : estimate.error().message;
    };
    EXPECT_NE(refusal(metres).find("check the unit"), std::string::npos) << refusal(metres);
    EXPECT_NE(refusal(turned).find("order of the columns"), std::string::npos) << refusal(turned);
    EXPECT_NE(refusal(inverse).find("no resting tip"), std::string::npos) << refusal(inverse);
    EXPECT_NE(refusal(two).find("one pivot only"), std::string::npos) << refusal(two);
  }
  EXPECT_FALSE(calibrate_pivot(turned, {.method = PivotMethod::robust}));
  EXPECT_FALSE(calibrate_pivot(good, {.given_tip = kTip + Vector3(0.1, 0, 0)}));
}

TEST(Pivot, ASegmentWithoutAnyInlierIsNamed) {
  Random random(20);
  auto poses = swing(random, {.segments = 4, .poses = 30, .place_noise = 1e-4});
  for (auto& pose : poses)
    if (pose.segment == 3) pose.translation += 0.3 * normal3(random);
  const auto estimate = calibrate_pivot(poses, {.method = PivotMethod::robust});
  ASSERT_FALSE(estimate.has_value());
  EXPECT_NE(estimate.error().message.find("no pose of segment 4 agrees"), std::string::npos)
      << estimate.error().message;
}

// All turns but those about one axis go with the outliers: what is left cannot carry the tip.
TEST(Pivot, InliersThatTurnAboutOneAxisOnlyAreRefused) {
  Random random(21);
  auto poses = swing(random, {.poses = 60, .one_axis = true});
  for (int i = 0; i < 6; ++i) {
    PivotPose pose{so3_exp(normal3(random, 0.5)), normal3(random, 0.3), 0, std::nullopt};
    poses.push_back(pose);
  }
  const auto estimate = calibrate_pivot(poses, {.method = PivotMethod::robust});
  ASSERT_FALSE(estimate.has_value());
  EXPECT_NE(estimate.error().message.find("about one axis only"), std::string::npos)
      << estimate.error().message;
}

}  // namespace
}  // namespace palpate::calibration
