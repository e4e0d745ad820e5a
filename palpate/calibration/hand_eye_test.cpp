#include "palpate/calibration/hand_eye.h"

#include <gtest/gtest.h>

#include "palpate/calibration/internal/hand_eye_motion.h"
#include "palpate/calibration/internal/motion_correlation.h"
#include "palpate/calibration/two_streams_for_tests.h"
#include "palpate/core/random.h"
#include "palpate/core/units.h"
#include "palpate/math/linear_algebra.h"
#include "tests/chi_square.h"

namespace palpate::calibration {
namespace {

TEST(HandEye, PerfectPosesGiveEverythingBack) {
  TwoStreams lab;
  lab.hand_rate = 1000.0;  // between hand poses 1 ms apart the straight line errs by 1e-7 m
  Random random(1, "hand-eye");
  const auto fit = calibrate_hand_eye(lab.hand(random), lab.eye(random), {.estimate_delay = true});
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_LT(lab.place_error(fit->value), 1e-6);
  EXPECT_LT(lab.turn_error(fit->value), 1e-6);
  EXPECT_NEAR(fit->value.delay_s, lab.delay, 2e-6);
  EXPECT_LT((fit->value.X_world_board.translation - lab.Z.translation).norm(), 1e-6);
  EXPECT_TRUE(fit->value.warnings.empty()) << fit->value.warnings.front();
}

// A marker at rest is seen now and then; at 10 Hz the gap is the largest that is read between, but for its rounding.
TEST(HandEye, PosesOfTheSameTimesArePairsHoweverFarApartTheyAre) {
  for (const double rate : {1.0, 10.0}) {
    TwoStreams lab;
    lab.delay = 0.0;
    lab.hand_rate = lab.eye_rate = rate;
    Random random(1, "hand-eye");
    const auto eye = lab.eye(random);
    const auto fit = calibrate_hand_eye(lab.hand(random), eye);
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_LT(lab.place_error(fit->value), 1e-6) << rate;
    EXPECT_EQ(static_cast<std::size_t>(fit->value.pairs), eye.size()) << rate;
  }
}

TEST(HandEye, OrderAndRepetitionOfRowsDoNotMatter) {
  TwoStreams lab;
  lab.eye_turn_noise = 0.002, lab.eye_place_noise = 0.001;
  Random random(2, "hand-eye");
  const auto hand = lab.hand(random), eye = lab.eye(random);
  auto mixed = eye;
  std::swap(mixed[3], mixed[400]);
  mixed.push_back(mixed[17]);
  const auto a = calibrate_hand_eye(hand, eye, {.estimate_delay = true});
  const auto b = calibrate_hand_eye({hand.rbegin(), hand.rend()}, mixed, {.estimate_delay = true});
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->value.X_marker_camera.translation, b->value.X_marker_camera.translation);
  EXPECT_EQ(a->value.delay_s, b->value.delay_s);
}

TEST(HandEye, AKnownDelayIsUsedAsItIs) {
  TwoStreams lab;
  Random random(3, "hand-eye");
  const auto fit = calibrate_hand_eye(lab.hand(random), lab.eye(random), {.delay_s = lab.delay});
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_EQ(fit->value.delay_s, lab.delay);
  EXPECT_EQ(fit->value.delay_std_s, 0.0);
  EXPECT_LT(lab.place_error(fit->value), 1e-4);  // straight lines between hand poses 10 ms apart
}

TEST(HandEyeStatistics, ErrorsAgreeWithTheCovarianceItClaims) {
  constexpr int kRuns = 100;
  TwoStreams lab;
  lab.seconds = 20.0, lab.eye_rate = 29.3;  // at a simple part of 100 Hz the delay is drawn by 0.05 ms
  lab.eye_turn_noise = 0.003, lab.eye_place_noise = 0.002;
  lab.hand_turn_noise = 0.0005, lab.hand_place_noise = 0.0002;
  Eigen::VectorXd each = Eigen::VectorXd::Zero(7);
  double together = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    Random random(100 + static_cast<std::uint64_t>(run), "hand-eye");
    const auto eye = lab.eye(random);
    const auto fit = calibrate_hand_eye(lab.hand(random), eye, {.estimate_delay = true});
    ASSERT_TRUE(fit) << fit.error().message;
    Eigen::VectorXd error(7);
    error << so3_log(lab.X.rotation * fit->value.X_marker_camera.rotation.conjugate()),
        lab.X.translation - fit->value.X_marker_camera.translation, lab.delay - fit->value.delay_s;
    const std::array found{0, 1, 2, 3, 4, 5, 12};  // without the board
    const Eigen::MatrixXd C = fit->covariance(found, found);
    EXPECT_NEAR(std::sqrt(C(6, 6)), fit->value.delay_std_s, 1e-9 * fit->value.delay_std_s);
    each += error.cwiseAbs2().cwiseQuotient(C.diagonal());
    together += tests::normalised_square(error, C);
  }
  constexpr double kCautious =
      0.81;  // of 1,000 runs: white noise is taken in part for what comes with the place
  EXPECT_TRUE(tests::is_chi_square(together / kCautious, 7 * kRuns));
  for (int i = 0; i < 7; ++i) EXPECT_TRUE(tests::is_chi_square(each(i) / kCautious, kRuns)) << i;
}

// A tracker whose error changes smoothly with the marker's place, as bias fields do: cosines of random waves.
struct BiasField {
  struct Wave {
    Vector3 k, turn, place;
    double phase;
  };
  std::vector<Wave> waves;
  BiasField(Random& random, double place_sd, double turn_sd, double length) {
    for (int i = 0; i < 24; ++i) {
      const double share = std::sqrt(2.0 / 24.0);
      waves.push_back({TwoStreams::noise(random, 1.0 / length), TwoStreams::noise(random, share * turn_sd),
                       TwoStreams::noise(random, share * place_sd), random.uniform(0.0, 6.28)});
    }
  }
  void bend(std::vector<device::StampedPose>& poses) const {
    for (auto& pose : poses) {
      Vector3 turn = Vector3::Zero(), place = Vector3::Zero();
      for (const auto& w : waves) {
        const double c = std::cos(w.k.dot(pose.translation) + w.phase);
        turn += c * w.turn, place += c * w.place;
      }
      pose.rotation = so3_exp(turn) * pose.rotation;
      pose.translation += place;
    }
  }
};

TEST(HandEyeStatistics, ATrackersSmoothBiasIsInTheCovariance) {
  TwoStreams lab;
  lab.seconds = 20.0;
  lab.eye_turn_noise = 0.001, lab.eye_place_noise = 0.0005, lab.hand_turn_noise = 0.0005,
  lab.hand_place_noise = 0.0001;
  Vector3 place = Vector3::Zero(), turn = Vector3::Zero(), white = Vector3::Zero();
  constexpr int kRuns = 60;
  for (int run = 0; run < kRuns; ++run) {
    Random random(300 + static_cast<std::uint64_t>(run), "hand-eye"), field(random.bits(), "bias");
    auto hand = lab.hand(random);
    const auto eye = lab.eye(random);
    BiasField(field, 0.0002, 0.001, 0.15).bend(hand);
    const auto fit = calibrate_hand_eye(hand, eye, {.estimate_delay = true});
    ASSERT_TRUE(fit) << fit.error().message;
    const Vector3 e = lab.X.translation - fit->value.X_marker_camera.translation,
                  r = so3_log(lab.X.rotation * fit->value.X_marker_camera.rotation.conjugate());
    for (int i = 0; i < 3; ++i) {
      turn(i) += std::pow(r(i) / fit->standard_deviation(i), 2);
      place(i) += std::pow(e(i) / fit->standard_deviation(3 + i), 2);
      white(i) += std::pow(e(i) / fit->standard_deviation(3 + i) * fit->value.grown_by, 2);
    }
  }
  EXPECT_TRUE(tests::is_at_most_chi_square(turn.sum(), 3 * kRuns)) << turn.transpose();
  EXPECT_TRUE(tests::is_at_most_chi_square(place.sum(), 3 * kRuns)) << place.transpose();
  // How wide is a matter of the field's length, of which one recording tells little: not absurdly wide.
  EXPECT_GT(place.mean() / kRuns, 0.1) << place.transpose();
  EXPECT_FALSE(tests::is_at_most_chi_square(white.sum(), 3 * kRuns)) << "what white noise would have claimed";
}

TEST(HandEye, ClocksFarApartAreFound) {
  TwoStreams lab;
  lab.eye_turn_noise = 0.01, lab.eye_place_noise = 0.005;
  for (double delay : {-1491754391.25, -7.3, 0.0, 6.2, 3600.5}) {
    lab.delay = delay;
    Random random(5, "hand-eye");
    const auto fit = calibrate_hand_eye(lab.hand(random), lab.eye(random), {.estimate_delay = true});
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_NEAR(fit->value.delay_s, delay, 0.002) << delay;  // 0.4 ms is the deviation stated
  }
}

TEST(HandEye, RegularSwingingDoesNotFitASwingOff) {
  TwoStreams lab;  // turns at one frequency, with a small irregular tremble
  lab.turn = [](double t) {
    const double a = 2 * std::numbers::pi * 0.8 * t;
    return Vector3(0.15 * std::sin(a) + 0.01 * std::sin(7.3 * t),
                   0.17 * std::sin(a + 1.0) + 0.02 * std::sin(0.37 * t), 0.1 * std::sin(a + 2.0));
  };
  lab.eye_turn_noise = 0.003, lab.eye_place_noise = 0.002;
  lab.delay = 0.45;
  Random random(6, "hand-eye");
  const auto fit = calibrate_hand_eye(lab.hand(random), lab.eye(random), {.estimate_delay = true});
  ASSERT_TRUE(fit) << fit.error().message;
  EXPECT_NEAR(fit->value.delay_s, lab.delay, 0.003);
}

TEST(HandEye, BlundersDoNotPull) {
  TwoStreams lab;
  lab.eye_turn_noise = 0.003, lab.eye_place_noise = 0.002;
  Random random(7, "hand-eye"), blunder(7, "blunders");
  auto eye = lab.eye(random);
  const auto clean = calibrate_hand_eye(lab.hand(random), eye, {.estimate_delay = true});
  for (auto& pose : eye)
    if (blunder.chance(0.15)) {
      pose.rotation = pose.rotation * so3_exp(TwoStreams::noise(blunder, 0.3));
      pose.translation += TwoStreams::noise(blunder, 0.2);
    }
  const auto fit = calibrate_hand_eye(lab.hand(random), eye, {.estimate_delay = true});
  ASSERT_TRUE(clean && fit);
  EXPECT_LT(lab.place_error(fit->value), 2.0 * lab.place_error(clean->value) + 0.0005);
  const auto out = std::count(fit->inlier.begin(), fit->inlier.end(), false);
  EXPECT_NEAR(static_cast<double>(out) / static_cast<double>(fit->inlier.size()), 0.15, 0.03);
}

TEST(HandEye, RefusesTurnsAboutOneAxisOnly) {
  TwoStreams lab;
  lab.turn = [](double t) { return Vector3(0, 0.5 * std::sin(1.3 * t), 0); };
  lab.eye_turn_noise = 0.002, lab.eye_place_noise = 0.001;
  Random random(8, "hand-eye");
  const auto fit = calibrate_hand_eye(lab.hand(random), lab.eye(random), {.delay_s = lab.delay});
  ASSERT_FALSE(fit);
  EXPECT_EQ(fit.error().exit_code(), 1);
  EXPECT_NE(fit.error().message.find("second axis"), std::string::npos) << fit.error().message;
}

TEST(HandEye, RefusesACameraThatDoesNotTurn) {
  TwoStreams lab;
  lab.turn = [](double) { return Vector3(0.1, 0.2, 0.3); };
  lab.eye_turn_noise = 0.002, lab.eye_place_noise = 0.001;
  for (bool estimate : {false, true}) {
    Random random(9, "hand-eye");
    const auto fit = calibrate_hand_eye(lab.hand(random), lab.eye(random),
                                        {.estimate_delay = estimate, .delay_s = lab.delay});
    ASSERT_FALSE(fit) << estimate;
    EXPECT_NE(fit.error().message.find("turn"), std::string::npos) << fit.error().message;
  }
}

TEST(HandEye, WarnsOfNearlyParallelAxes) {
  TwoStreams lab;
  lab.turn = [](double t) {
    return Vector3(0.06 * std::sin(2.1 * t), 0.5 * std::sin(1.3 * t), 0.06 * std::sin(0.7 * t));
  };
  lab.eye_turn_noise = 0.001, lab.eye_place_noise = 0.0005;
  Random random(10, "hand-eye");
  const auto fit = calibrate_hand_eye(lab.hand(random), lab.eye(random), {.estimate_delay = true});
  ASSERT_TRUE(fit) << fit.error().message;
  ASSERT_FALSE(fit->value.warnings.empty());
  EXPECT_NE(fit->value.warnings.front().find("parallel"), std::string::npos);
}

TEST(HandEye, AHandThatIsSlowerThanItsEyeIsAskedFor) {
  TwoStreams lab;
  Random random(16, "hand-eye");
  auto hand = lab.hand(random);
  const auto eye = lab.eye(random);
  std::vector<device::StampedPose> slow;
  for (std::size_t i = 0; i < hand.size(); i += 30) slow.push_back(hand[i]);
  const auto fit = calibrate_hand_eye(slow, eye, {.max_hand_gap_s = 0.01});
  ASSERT_FALSE(fit);
  EXPECT_NE(fit.error().message.find("are hand and eye exchanged?"), std::string::npos)
      << fit.error().message;
  EXPECT_EQ(fit.error().message.find("--estimate-delay"), std::string::npos);
  // Of clocks that have no time in common the clocks are what is wrong.
  auto later = eye;
  for (auto& pose : later) pose.time_s += 1000.0;
  const auto far = calibrate_hand_eye(slow, later, {.max_hand_gap_s = 0.01});
  ASSERT_FALSE(far);
  EXPECT_NE(far.error().message.find("use --estimate-delay"), std::string::npos) << far.error().message;
}

// Of two takes that have nothing to do with each other the best of all delays is no answer.
TEST(HandEye, AnotherTakeIsRefusedAtAnyDelay) {
  int refused = 0;
  for (int seed = 0; seed < 8; ++seed) {
    TwoStreams one, other;
    other.turn = [seed](double t) {
      return Vector3(0.3 * std::sin((0.9 + 0.1 * seed) * t), 0.4 * std::sin(1.7 * t + seed),
                     0.3 * std::cos((0.6 + 0.05 * seed) * t));
    };
    Random random(static_cast<std::uint64_t>(20 + seed), "hand-eye");
    const auto fit = calibrate_hand_eye(one.hand(random), other.eye(random), {.estimate_delay = true});
    if (!fit) ++refused;
    if (fit) EXPECT_LT(fit->value.rotation_residual_median, 0.14);
  }
  EXPECT_GE(refused, 6);
}

TEST(HandEye, WarnsOfExchangedRolesAndOfAnotherUnit) {
  const auto warned = [](const auto& fit, const char* words) {
    EXPECT_TRUE(fit) << (fit ? "" : fit.error().message);
    return fit && std::any_of(fit->value.warnings.begin(), fit->value.warnings.end(),
                              [&](const auto& w) { return w.find(words) != std::string::npos; });
  };
  auto tracker = ethz("vicon_prime_sense.csv"), camera = ethz("W_camera_rgb_image_raw.csv");
  const HandEyeOptions how{.estimate_delay = true};
  EXPECT_TRUE(warned(calibrate_hand_eye(camera, tracker, how), "hand and eye seem to be exchanged"));
  const auto right = calibrate_hand_eye(tracker, camera, how);
  EXPECT_FALSE(warned(right, "exchanged"));
  for (auto* poses : {&tracker, &camera})
    for (auto& pose : *poses) pose.translation *= 1000.0;
  const auto metres = calibrate_hand_eye(tracker, camera, how);
  ASSERT_FALSE(metres);  // known to 4 mm, read as metres
  EXPECT_NE(metres.error().message.find("check the unit"), std::string::npos) << metres.error().message;
}

TEST(HandEye, AWrongTimeStampIsLeftOutAndTold) {
  TwoStreams lab;
  lab.eye_turn_noise = 0.001, lab.eye_place_noise = 0.0005;
  Random random(21, "hand-eye");
  const auto hand = lab.hand(random), eye = lab.eye(random);
  for (const bool of_eye : {false, true})
    for (const double time : {1e9, -1e6}) {
      auto broken_hand = hand, broken_eye = eye;
      (of_eye ? broken_eye : broken_hand)[20].time_s = time;
      const auto fit = calibrate_hand_eye(broken_hand, broken_eye, {.estimate_delay = true});
      ASSERT_TRUE(fit) << fit.error().message;
      EXPECT_LT(lab.place_error(fit->value), 0.005);
      ASSERT_FALSE(fit->value.warnings.empty());
      EXPECT_NE(fit->value.warnings.front().find("1 pose left out"), std::string::npos);
    }
}

TEST(HandEye, WarnsOfFewPoses) {
  TwoStreams lab;
  lab.seconds = 200.0, lab.hand_rate = lab.eye_rate = 0.05, lab.delay = 0.0;
  lab.eye_turn_noise = 0.002, lab.eye_place_noise = 0.001;
  lab.eye_rate = lab.hand_rate;
  Random random(14, "hand-eye");
  const auto hand = lab.hand(random);
  std::vector<device::StampedPose> eye;
  for (const auto& h : hand) {
    const auto pose = lab.Z.inverse() * lab.marker(h.time_s) * lab.X;
    eye.push_back({h.time_s, so3_exp(TwoStreams::noise(random, 0.002)) * pose.rotation,
                   pose.translation + TwoStreams::noise(random, 0.001)});
  }
  ASSERT_EQ(eye.size(), 10u);
  const auto fit = calibrate_hand_eye(hand, eye, {.max_hand_gap_s = 30.0});
  ASSERT_TRUE(fit) << fit.error().message;
  ASSERT_FALSE(fit->value.warnings.empty());
  EXPECT_NE(fit->value.warnings.front().find("few"), std::string::npos) << fit->value.warnings.front();
  EXPECT_LT(lab.place_error(fit->value), 0.02);
}

TEST(HandEye, WarnsOfPosesThatAreTheSameForLong) {
  TwoStreams lab;
  lab.turn = [turn = lab.turn](double t) { return turn(5.0 * std::floor(t / 5.0)); };
  lab.place = [place = lab.place](double t) { return place(5.0 * std::floor(t / 5.0)); };
  lab.delay = 0.0;
  lab.eye_turn_noise = 0.001, lab.eye_place_noise = 0.0005;
  Random random(15, "hand-eye");
  const auto fit = calibrate_hand_eye(lab.hand(random), lab.eye(random), {});
  ASSERT_TRUE(fit) << fit.error().message;
  ASSERT_FALSE(fit->value.warnings.empty());
  EXPECT_NE(fit->value.warnings.front().find("differ by more than 2 deg"), std::string::npos)
      << fit->value.warnings.front();
}

// The real recording cut down to the poses that turn about one axis: within `band` of the arc through the
// middle.
TEST(HandEye, WarnsOfARealRecordingCutDownToOneAxis) {
  const auto hand = ethz("vicon_prime_sense.csv"), eye = ethz("W_camera_rgb_image_raw.csv");
  Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
  for (const auto& e : eye) M += e.rotation.coeffs() * e.rotation.coeffs().transpose();
  Quaternion mean;
  mean.coeffs() = symmetric_eigen(M).vectors.col(3);
  Matrix3 scatter = Matrix3::Zero();
  for (const auto& e : eye) {
    const Vector3 w = so3_log(mean.conjugate() * e.rotation);
    scatter += w * w.transpose();
  }
  const Vector3 axis = symmetric_eigen(scatter).vectors.col(2);
  for (double band : {0.07, 0.1, 0.13}) {  // rad
    std::vector<device::StampedPose> some;
    for (const auto& e : eye) {
      const Vector3 w = so3_log(mean.conjugate() * e.rotation);
      if ((w - axis * axis.dot(w)).norm() < band) some.push_back(e);
    }
    ASSERT_GT(some.size(), 20u) << band;
    const auto fit = calibrate_hand_eye(hand, some, {.delay_s = 0.017});
    EXPECT_TRUE(!fit || !fit->value.warnings.empty()) << band;
    if (fit) {  // and the answer, however poor, is as good as it says
      const Vector3 off = fit->value.X_marker_camera.translation - Vector3(0.0766, 0.0426, 0.0274);
      for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(off(i)), 4.0 * fit->standard_deviation(3 + i)) << band;
    }
  }
}

TEST(HandEye, ClosedFormsSolvePerfectPoses) {
  TwoStreams lab;
  std::vector<HandAt> hand;
  std::vector<device::StampedPose> eye;
  for (int i = 0; i < 60; ++i) {
    const auto marker = lab.marker(0.4 * i);
    const auto camera = lab.Z.inverse() * marker * lab.X;
    hand.push_back({marker.rotation, marker.translation, {}, {}});
    eye.push_back({0.4 * i, camera.rotation, camera.translation});
  }
  const auto forms = hand_eye_closed_forms(hand, eye);
  ASSERT_EQ(forms.size(), 3u);
  for (const auto& form : forms) {
    EXPECT_LT((form.translation - lab.X.translation).norm(), 1e-9) << form.name;
    EXPECT_LT(angle_between(form.rotation, lab.X.rotation), 1e-9) << form.name;
  }
}

TEST(HandEye, SaysWhenTheClocksDoNotOverlap) {
  TwoStreams lab;
  lab.delay = 500.0;
  Random random(11, "hand-eye");
  const auto fit = calibrate_hand_eye(lab.hand(random), lab.eye(random), {});
  ASSERT_FALSE(fit);
  EXPECT_NE(fit.error().message.find("--estimate-delay"), std::string::npos);
}

TEST(HandEye, RefusesStreamsOfDifferentRecordings) {
  TwoStreams lab, other;
  other.turn = [](double t) {
    return Vector3(0.3 * std::sin(3.1 * t), 0.2 * std::cos(0.3 * t * t),
                   0.3 * std::sin(2.9 * t + 0.1 * t * t));
  };
  lab.eye_turn_noise = 0.02;
  Random random(12, "hand-eye");
  const auto fit = calibrate_hand_eye(other.hand(random), lab.eye(random), {.estimate_delay = true});
  // either no common turning is found, or the fit cannot hold the camera's place
  EXPECT_TRUE(!fit || !fit->value.warnings.empty());
}

TEST(HandEye, RefusesWhatHasNothingToDoWithEachOtherOnOneClockToo) {
  TwoStreams lab, other;
  lab.delay = other.delay = 0.0;
  other.turn = [](double t) {
    return Vector3(1.1 * std::sin(1.7 * t), 1.2 * std::cos(2.3 * t), 1.1 * std::sin(0.9 * t + 1.0));
  };
  Random random(13, "hand-eye");
  const auto fit = calibrate_hand_eye(other.hand(random), lab.eye(random), {});
  ASSERT_FALSE(fit);
  EXPECT_NE(fit.error().message.find("are of the same take"), std::string::npos) << fit.error().message;
}

TEST(HandEye, RealRecordingAgreesWithAnIndependentFit) {
  const auto fit = calibrate_hand_eye(ethz("vicon_prime_sense.csv"), ethz("W_camera_rgb_image_raw.csv"),
                                      {.estimate_delay = true});
  ASSERT_TRUE(fit) << fit.error().message;
  const auto& s = fit->value;
  // data/ethz_handeye_primesense1/ORIGIN.md; two takes of the rig agree to 8 mm and 0.6 deg
  EXPECT_LT((1e3 * s.X_marker_camera.translation - Vector3(76.6, 42.6, 27.4)).norm(), 8.0);
  const Quaternion reference = Quaternion(0.60748, -0.41838, 0.36509, -0.56800).normalized();
  EXPECT_LT(degrees_from_radians(angle_between(s.X_marker_camera.rotation, reference)), 0.6);
  EXPECT_NEAR(s.delay_s, 0.0170, 0.004);
  EXPECT_NEAR(degrees_from_radians(s.rotation_residual_median), 1.01, 0.1);
  EXPECT_NEAR(1e3 * s.translation_residual_median, 14.2, 1.0);
  // Two takes of the rig differ by 8 mm: sqrt(2) times the stated deviation of the place is of that size.
  const double stated = std::sqrt(2.0 * fit->covariance.block<3, 3>(3, 3).trace());
  EXPECT_GT(stated, 0.0055);
  EXPECT_LT(stated, 0.016);
  EXPECT_TRUE(s.warnings.empty()) << s.warnings.front();  // it moves well
}

TEST(MotionCorrelation, FindsDelayAndRotationToAFractionOfItsGrid) {
  TwoStreams lab;
  lab.delay = 2.3456;
  lab.eye_turn_noise = 0.01;
  Random random(13, "hand-eye");
  const auto candidates = delay_candidates(lab.hand(random), lab.eye(random));
  ASSERT_FALSE(candidates.empty());
  EXPECT_NEAR(candidates.front().delay_s, lab.delay, 0.005);
  EXPECT_GT(candidates.front().correlation, 0.95);
  EXPECT_LT(degrees_from_radians(angle_between(candidates.front().R_hand_eye, lab.X.rotation)), 1.0);
}

}  // namespace
}  // namespace palpate::calibration
