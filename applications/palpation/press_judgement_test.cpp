// What the trainee makes of a press, against sums done by other means: Riemann sums on a finer time axis, the closed form of a
// difference of Gaussian judgements, and the published proportions.
#include "applications/palpation/press_judgement.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/experiment/normal.h"

namespace palpate::applications::palpation {
namespace {

// Hertz: exactly k d^1.5.
ForceCurve hertz(double stiffness) {
  return {{0.001, 0.005}, {stiffness * std::pow(0.001, 1.5), stiffness * std::pow(0.005, 1.5)}};
}

double bias_of(const AddedDelay& delay, const Senses& senses) {
  TraineeSenses exact({1e-9, 1e-9, 1e-6, 0.5e-6}, 1);
  const double late = exact.judged(felt_inwards(hertz(1000.0), {}, delay), senses);
  return late - exact.judged(felt_inwards(hertz(1000.0), {}, {}), senses);
}

TEST(PressJudgement, OfAPressThatIsNotLateItIsTheStiffnessItself) {
  const auto felt = felt_inwards(hertz(1000.0), {.picture_late_s = 0.0}, {});
  // A tick is 1 ms of 400.
  EXPECT_NEAR(log_stiffness(felt.force, felt.hand), std::log(1000.0), 0.01);
  EXPECT_NEAR(log_stiffness(felt.force, felt.seen), std::log(1000.0), 0.01);
}

// The way of least jerk integrated once more, twenty times as fine, by its own polynomial.
TEST(PressJudgement, LateForceIsSofterByWhatTheIntegralSays) {
  constexpr double kLate = 0.06, kWay = 0.4;
  const auto depth = [](double t) {
    const double u = std::min(1.0, std::max(0.0, t / kWay));
    return 10.0 * std::pow(u, 3) - 15.0 * std::pow(u, 4) + 6.0 * std::pow(u, 5);
  };
  double product = 0.0, plain = 0.0, square = 0.0;
  for (int i = 0; i < 8000; ++i) {
    const double t = kWay * (i + 0.5) / 8000;
    product += std::pow(depth(t - kLate) * depth(t), 1.5);
    plain += std::pow(depth(t - 0.001) * depth(t), 1.5);
    square += std::pow(depth(t), 3);
  }
  ASSERT_LT(product, plain);
  EXPECT_NEAR(bias_of({.force = kLate - 0.001}, {.sight = false}), std::log(product / plain), 0.003);
  EXPECT_GT(square, plain);
}

TEST(PressJudgement, LateForceIsSofterLatePictureStifferBothPartlyCancel) {
  for (const double late : {0.02, 0.05, 0.1}) {
    const double force = bias_of({.force = late}, {}), picture = bias_of({.picture = late}, {}),
                 both = bias_of({.force = late, .picture = late}, {});
    EXPECT_LT(force, -0.01) << late;
    EXPECT_GT(picture, 0.01) << late;
    EXPECT_GT(both, force) << late;
    EXPECT_LT(both, picture) << late;
    EXPECT_LT(std::abs(both), 0.8 * std::max(-force, picture)) << late;
    EXPECT_NEAR(bias_of({.picture = late}, {.sight = false}), 0.0, 1e-5) << "who does not look is not misled";
  }
}

// Force held still at twice the picture's stiffness: the judgement lies between by the eye's weight (Ernst, Banks).
TEST(PressJudgement, ACueThatDisagreesPullsByItsReliability) {
  const SenseNoise noise = sense_noise(0.14);
  PressFelt felt;
  for (int i = 1; i <= 10; ++i) {
    const double depth = 0.0005 * i;
    felt.hand.push_back(depth);
    felt.seen.push_back(0.8 * depth);
    felt.force.push_back(500.0 * std::pow(depth, 1.5));
  }
  TraineeSenses exact({1e-9, 1e-9, 1e-7 * noise.hand, 1e-7 * noise.eye}, 3);
  const double pulled = exact.judged(felt, {}) - std::log(500.0);
  EXPECT_NEAR(pulled / (-1.5 * std::log(0.8)), TraineeSenses::eye_weight(noise), 1e-4);
  EXPECT_NEAR(TraineeSenses::eye_weight(noise), 0.085 * 0.085 / (0.085 * 0.085 + 0.04 * 0.04), 1e-9);
}

TEST(PressJudgement, NoiseAddsUpToThePublishedWeberFractions) {
  const SenseNoise noise = sense_noise(0.22);
  const auto sum = [](double a, double b) { return std::hypot(a, b); };
  EXPECT_NEAR(noise.force, experiment::noise_of_weber_fraction(0.07), 1e-12);
  EXPECT_NEAR(sum(noise.force, noise.memory), experiment::noise_of_weber_fraction(0.08), 1e-12);
  EXPECT_NEAR(sum(sum(noise.force, noise.memory), noise.hand), experiment::noise_of_weber_fraction(0.22),
              1e-12);
  const SenseNoise practised = sense_noise(experiment::practised_weber_fraction(6));
  EXPECT_NEAR(sum(sum(practised.force, practised.memory), practised.hand),
              experiment::noise_of_weber_fraction(0.14), 1e-12);
}

// Two judgements of Gaussian noise: right with the chance Phi(difference / (root 2 times noise)).
TEST(PressJudgement, TwoPlacesAreToldAsOftenAsTheClosedFormSays) {
  constexpr int kTrials = 40'000;  // enough to miss the memory's noise, the smallest
  const SenseNoise noise = sense_noise(0.14);
  const PressMotion quick{.inwards_s = 0.02, .picture_late_s = 0.0};
  const auto first = felt_inwards(hertz(1150.0), quick, {}), second = felt_inwards(hertz(1000.0), quick, {});
  for (const bool sight : {true, false}) {
    TraineeSenses senses(noise, 7);
    int right = 0;
    for (int i = 0; i < kTrials; ++i) {
      const double a = senses.judged(first, {.sight = sight});
      const double b = senses.judged(second, {.sight = sight});
      right += a > b;
    }
    const double hand = 1.5 * noise.hand, eye = 1.5 * noise.eye;
    const double depth = sight ? hand * eye / std::hypot(hand, eye) : hand;
    const double all = std::hypot(depth, std::hypot(noise.force, noise.memory));
    const double expected = experiment::normal_below(std::log(1.15) / (std::sqrt(2.0) * all));
    EXPECT_NEAR(static_cast<double>(right) / kTrials, expected,
                4.0 * std::sqrt(expected * (1.0 - expected) / kTrials));
  }
}

TEST(PressJudgement, WithItsSenseOffHardAndSoftFeelAlike) {
  TraineeSenses exact({1e-9, 1e-9, 1e-6, 0.5e-6}, 1);
  const Senses numb{.force = false};
  EXPECT_NEAR(exact.judged(felt_inwards(hertz(9000.0), {}, {}), numb),
              exact.judged(felt_inwards(hertz(1000.0), {}, {}), numb), 1e-5);
}

}  // namespace
}  // namespace palpate::applications::palpation
