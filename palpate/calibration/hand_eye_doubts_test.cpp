// What a hand-eye calibration says of streams that are not what they are said to be, and of clocks that differ where
// nobody asked by how much: the answer is wrong then, with nothing else to show for it.
#include <gtest/gtest.h>

#include <string_view>

#include "palpate/calibration/two_streams_for_tests.h"

namespace palpate::calibration {
namespace {

constexpr const char* kExchanged = "seem to be exchanged";
constexpr const char* kDelay = "--estimate-delay";

TwoStreams noisy() {
  TwoStreams lab;
  lab.delay = 0.0;
  lab.eye_turn_noise = 0.002, lab.eye_place_noise = 0.001;
  lab.hand_turn_noise = 0.0005, lab.hand_place_noise = 0.0002;
  return lab;
}

// The warnings that hold these words, all in one; with `words` empty all of them.
std::string warned(const Expected<Estimate<HandEyeSolution>>& fit, const std::string& words) {
  EXPECT_TRUE(fit) << (fit ? "" : fit.error().message);
  std::string found;
  if (fit)
    for (const auto& w : fit->value.warnings)
      if (w.find(words) != std::string::npos) found += w;
  return found;
}

TEST(HandEyeDoubts, ADelayThatNobodyAskedForIsToldOf) {
  for (const double delay : {0.03, -0.008, 2.5}) {
    TwoStreams lab = noisy();
    lab.delay = delay;
    Random random(1, "doubts");
    const auto hand = lab.hand(random), eye = lab.eye(random);
    const auto told = warned(calibrate_hand_eye(hand, eye), kDelay);
    constexpr std::string_view kBefore = "a delay of ";
    const auto at = told.find(kBefore);
    ASSERT_NE(at, std::string::npos) << delay << ": " << told;
    EXPECT_NEAR(std::stod(told.substr(at + kBefore.size())), delay, 0.001);
    EXPECT_EQ(warned(calibrate_hand_eye(hand, eye, {.doubt_delay = false}), kDelay), "");
    EXPECT_EQ(warned(calibrate_hand_eye(hand, eye, {.delay_s = delay}), kDelay), "") << delay;
    EXPECT_EQ(warned(calibrate_hand_eye(hand, eye, {.estimate_delay = true}), kDelay), "") << delay;
  }
}

TEST(HandEyeDoubts, AKnownDelayThatIsNotTheStreamsIsToldOf) {
  TwoStreams lab = noisy();
  lab.delay = 0.03;
  Random random(2, "doubts");
  EXPECT_NE(warned(calibrate_hand_eye(lab.hand(random), lab.eye(random), {.delay_s = -0.03}),
                   "in place of -0.0300 s"),
            "");
}

TEST(HandEyeDoubts, NoDelayIsDoubtedWhereThereIsNone) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    TwoStreams lab = noisy();
    lab.eye_turn_noise *= static_cast<double>(seed), lab.eye_place_noise *= static_cast<double>(seed);
    Random random(seed, "doubts");
    EXPECT_EQ(warned(calibrate_hand_eye(lab.hand(random), lab.eye(random)), kDelay), "") << seed;
  }
}

// A head that turns, rests for some seconds and turns again: at rest any delay fits.
TEST(HandEyeDoubts, NoDelayIsDoubtedWhereTheHeadMostlyRests) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    TwoStreams lab = noisy();
    const auto moment = [](double t) {
      const double begun = 3.0 * std::floor(t / 3.0);
      return begun + std::min(3.0, 6.0 * (t - begun));
    };
    lab.turn = [turn = lab.turn, moment](double t) { return turn(moment(t)); };
    lab.place = [place = lab.place, moment](double t) { return place(moment(t)); };
    Random random(seed, "doubts");
    EXPECT_EQ(warned(calibrate_hand_eye(lab.hand(random), lab.eye(random)), kDelay), "") << seed;
  }
}

TEST(HandEyeDoubts, TheDelayOfARealRecordingIsToldOfUnlessItIsUsed) {
  const auto hand = ethz("vicon_prime_sense.csv"), eye = ethz("W_camera_rgb_image_raw.csv");
  const auto found = calibrate_hand_eye(hand, eye, {.estimate_delay = true});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_NE(warned(calibrate_hand_eye(hand, eye), kDelay), "");
  EXPECT_EQ(warned(calibrate_hand_eye(hand, eye, {.delay_s = found->value.delay_s}), kDelay), "");
}

// A marker whose +z axis leads past the tracker by 60 deg: as the eye's poses it would be a board before the camera,
// but one that is never in its picture.
TEST(HandEyeDoubts, ExchangedStreamsAreNamedWhereTheTrackerLiesBeforeTheMarker) {
  TwoStreams lab = noisy();
  Random random(3, "doubts");
  auto hand = lab.hand(random);
  const auto eye = lab.eye(random);
  for (auto& pose : hand) pose.rotation = pose.rotation * so3_exp(Vector3(-1.7, 0.0, 0.0));
  EXPECT_NE(warned(calibrate_hand_eye(eye, hand), kExchanged), "");
  EXPECT_EQ(warned(calibrate_hand_eye(hand, eye), "exchanged"), "");
}

TEST(HandEyeDoubts, ARealRecordingsRolesAreNamedWhereTheyAreExchanged) {
  const auto hand = ethz("vicon_prime_sense.csv"), eye = ethz("W_camera_rgb_image_raw.csv");
  EXPECT_NE(warned(calibrate_hand_eye(eye, hand, {.estimate_delay = true}), kExchanged), "");
  EXPECT_EQ(warned(calibrate_hand_eye(hand, eye, {.estimate_delay = true}), "exchanged"), "");
}

std::string refusal(const std::vector<device::StampedPose>& hand, const std::vector<device::StampedPose>& eye,
                    bool estimate_delay) {
  const auto fit = calibrate_hand_eye(hand, eye, {.estimate_delay = estimate_delay});
  return fit ? "" : fit.error().message;
}

TEST(HandEyeDoubts, PosesTurnedRoundAreNamed) {
  for (const bool estimate : {false, true}) {
    TwoStreams lab = noisy();
    lab.delay = estimate ? 0.4 : 0.0;
    Random random(4, "doubts");
    const auto hand = lab.hand(random), eye = lab.eye(random);
    EXPECT_EQ(refusal(hand, eye, estimate), "");
    EXPECT_NE(refusal(hand, device::inverted(eye), estimate).find("the board's in the camera"),
              std::string::npos)
        << refusal(hand, device::inverted(eye), estimate);
    EXPECT_NE(refusal(device::inverted(hand), eye, estimate).find("the tracker's in the marker"),
              std::string::npos)
        << refusal(device::inverted(hand), eye, estimate);
  }
}

TEST(HandEyeDoubts, QuaternionsInAnotherOrderAreNamed) {
  const auto turned = [](std::vector<device::StampedPose> poses, bool first) {
    for (auto& pose : poses) {
      const Eigen::Vector4d c = pose.rotation.coeffs();  // x y z w
      // Read as w x y z is x y z w, or the other way round.
      pose.rotation = first ? Quaternion(c[0], c[1], c[2], c[3]) : Quaternion(c[2], c[3], c[0], c[1]);
    }
    return poses;
  };
  const auto expect_named = [&](const auto& hand, const auto& eye, bool estimate) {
    for (const bool first : {true, false}) {
      const std::string held =
          first ? "read as qw,qx,qy,qz, they hold qx,qy,qz,qw" : "read as qx,qy,qz,qw, they hold qw,qx,qy,qz";
      const auto with_eye = refusal(hand, turned(eye, first), estimate),
                 with_hand = refusal(turned(hand, first), eye, estimate),
                 with_both = refusal(turned(hand, first), turned(eye, first), estimate);
      EXPECT_NE(with_eye.find("of the eye's quaternions in another order: " + held), std::string::npos)
          << with_eye;
      EXPECT_NE(with_hand.find("of the hand's quaternions in another order: " + held), std::string::npos)
          << with_hand;
      EXPECT_NE(with_both.find("of both quaternions in another order: " + held), std::string::npos)
          << with_both;
    }
  };
  TwoStreams lab = noisy();
  Random random(6, "doubts");
  const auto hand = lab.hand(random), eye = lab.eye(random);
  expect_named(hand, eye, false);
  expect_named(ethz("vicon_prime_sense.csv"), ethz("W_camera_rgb_image_raw.csv"), true);
}

// The turns still fit, so that nothing but the places says that a column was taken for another.
TEST(HandEyeDoubts, PlacesThatDoNotFitWhereTheTurnsDoAreRefused) {
  const auto hand = ethz("vicon_prime_sense.csv"), eye = ethz("W_camera_rgb_image_raw.csv");
  EXPECT_EQ(refusal(hand, eye, true), "");
  for (const auto& [a, b] : {std::pair{0, 1}, {1, 2}, {0, 2}}) {
    auto swapped = hand;
    for (auto& pose : swapped) std::swap(pose.translation[a], pose.translation[b]);
    EXPECT_NE(refusal(swapped, eye, true).find("the order and signs of x, y and z"), std::string::npos)
        << a << b << ": " << refusal(swapped, eye, true);
  }
}

TEST(HandEyeDoubts, PosesOfARealRecordingTurnedRoundAreNamed) {
  const auto hand = ethz("vicon_prime_sense.csv"), eye = ethz("W_camera_rgb_image_raw.csv");
  EXPECT_NE(refusal(hand, device::inverted(eye), true).find("the board's in the camera"), std::string::npos);
  EXPECT_NE(refusal(device::inverted(hand), eye, true).find("the tracker's in the marker"),
            std::string::npos);
}

TEST(HandEyeDoubts, LengthsInAnotherUnitAreToldByHowMuch) {
  for (const double times : {0.001, 0.01, 0.0254, 10.0, 1000.0}) {
    TwoStreams lab = noisy();
    Random random(5, "doubts");
    const auto hand = lab.hand(random);
    auto eye = lab.eye(random);
    for (auto& pose : eye) pose.translation *= times;
    const auto told = refusal(hand, eye, false);
    constexpr std::string_view kBefore = "the eye's places fit ";
    const auto at = told.find(kBefore);
    ASSERT_NE(at, std::string::npos) << times << ": " << told;
    EXPECT_NEAR(std::stod(told.substr(at + kBefore.size())) * times, 1.0, 0.05) << told;
  }
}

// A board printed at 104 % is no other unit, and few poses turned about one axis tell nothing of it.
TEST(HandEyeDoubts, NoUnitIsDoubtedForALargerBoardOrPoorMotion) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    TwoStreams lab = noisy();
    if (seed > 5)
      lab.turn = [](double t) { return Vector3(0.02 * std::sin(t), 0.4 * std::sin(1.3 * t), 0.0); };
    Random random(seed, "doubts");
    const auto hand = lab.hand(random);
    auto eye = lab.eye(random);
    for (auto& pose : eye) pose.translation *= 1.04;
    EXPECT_EQ(refusal(hand, eye, false).find("times as long"), std::string::npos);
  }
}

}  // namespace
}  // namespace palpate::calibration
