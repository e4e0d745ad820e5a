#include "palpate/physics/hunt_crossley.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "palpate/core/random.h"
#include "palpate/physics/contact.h"

namespace palpate::physics {
namespace {

constexpr double kShell = 0.0027;  // kg

// docs/theory/contact.md: 4 ms and e = 0.93 at 5 m/s; tolerances: half of the last digit there.
TEST(HuntCrossley, HasTheTabulatedParameters) {
  const HuntCrossley linear(kShell, 0.93, 0.004, 5.0, 1.0), hertz(kShell, 0.93, 0.004, 5.0, 1.5);
  EXPECT_NEAR(linear.stiffness(), 1667.2, 0.06);
  EXPECT_NEAR(hertz.stiffness(), 22602.0, 2.0);  // of a coarser integration
  for (const auto* law : {&linear, &hertz}) {
    EXPECT_NEAR(law->damping(), 0.02257, 6e-6);
    const double speeds[] = {1.0, 5.0, 10.0, 20.0}, expected[] = {0.9852, 0.9300, 0.8690, 0.7674};
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(law->restitution(speeds[i]), expected[i], 6e-5);
  }
  const double speeds[] = {1.0, 5.0, 10.0, 20.0}, ms[] = {5.49, 4.00, 3.51, 3.11},
               peaks[] = {1.80, 12.0, 27.0, 60.2};
  for (int i = 0; i < 4; ++i) {
    const auto contact = hertz.contact(speeds[i]);
    EXPECT_NEAR(1e3 * contact.duration(), ms[i], 0.006);
    double peak = 0.0;
    for (int k = 0; k <= 1000; ++k) peak = std::max(peak, contact.force(contact.duration() * k / 1000));
    EXPECT_NEAR(peak / peaks[i], 1.0, 0.004);
  }
}

// Independent of table and interpolation: the differential equation in SI with steps thirty times finer.
TEST(HuntCrossley, TheStoredMotionSolvesItsEquation) {
  for (const double n : {1.0, 1.5, 2.2}) {
    const HuntCrossley law(kShell, 0.8, 0.004, 5.0, n);
    for (const double speed : {0.3, 5.0, 20.0}) {
      const auto contact = law.contact(speed);
      const auto a = [&](double x, double v) {
        return -law.stiffness() * std::pow(std::max(x, 0.0), n) * (1.0 + law.damping() * v) / kShell;
      };
      constexpr int kFine = 8000;
      const double h = contact.duration() / kFine;
      double x = 0.0, v = speed;
      for (int i = 0; i < kFine; ++i) {
        ASSERT_NEAR(contact.penetration(i * h), x, 1e-6 * speed * contact.duration());
        ASSERT_NEAR(contact.velocity(i * h), v, 1e-5 * speed);
        const double k1 = a(x, v), k2 = a(x + 0.5 * h * v, v + 0.5 * h * k1);
        const double k3 = a(x + 0.5 * h * (v + 0.5 * h * k1), v + 0.5 * h * k2);
        const double k4 = a(x + h * (v + 0.5 * h * k2), v + h * k3);
        x += h * (v + h * (k1 + k2 + k3) / 6.0);
        v += h * (k1 + 2 * k2 + 2 * k3 + k4) / 6.0;
      }
      EXPECT_NEAR(x, 0.0, 1e-6 * speed * contact.duration());
      EXPECT_NEAR(-v / speed, contact.restitution(), 1e-6) << "the conserved quantity and the motion agree";
    }
  }
}

TEST(HuntCrossley, ImpulseIsExactAtAnyRateAndPhase) {
  Random random(1, "hunt_crossley/phase");
  for (int i = 0; i < 300; ++i) {
    const HuntCrossley law(kShell, random.uniform(0.1, 1.0), random.uniform(0.0005, 0.006), 5.0,
                           random.uniform(1.0, 2.0));
    const double speed = std::exp(random.uniform(std::log(0.1), std::log(30.0)));
    const auto contact = law.contact(speed);
    const double dt = random.uniform(1e-5, 0.01), phase = random.uniform(0.0, dt);
    double impulse = 0.0;
    for (double t = -phase; t < contact.duration(); t += dt) impulse += contact.mean_force(t, t + dt) * dt;
    ASSERT_NEAR(impulse / (kShell * (1.0 + contact.restitution()) * speed), 1.0, 1e-9);
  }
}

TEST(HuntCrossley, ItNeverPullsAndBeginsAndEndsWithoutForce) {
  for (const double e : {0.1, 0.5, 0.93, 1.0}) {
    const auto contact = HuntCrossley(kShell, e, 0.004, 5.0).contact(8.0);
    double lowest = 0.0, highest = 0.0;
    for (int k = 0; k <= 4000; ++k) {
      lowest = std::min(lowest, contact.force(contact.duration() * k / 4000));
      highest = std::max(highest, contact.force(contact.duration() * k / 4000));
    }
    EXPECT_GE(lowest, 0.0) << e;
    EXPECT_NEAR(contact.force(0.0), 0.0, 1e-12);
    EXPECT_NEAR(contact.force(contact.duration()), 0.0, 1e-4 * highest);
  }
}

TEST(HuntCrossley, ALinearSpringWithoutDampingIsTheClosedForm) {
  const HuntCrossley law(kShell, 1.0, 0.004, 5.0, 1.0);
  const DampedContact exact(kShell, 1.0, 0.004, Release::where_rest_length_is_back);
  EXPECT_NEAR(law.stiffness() / exact.stiffness(), 1.0, 1e-6);
  const auto contact = law.contact(3.0);
  for (int k = 0; k <= 100; ++k) {
    EXPECT_NEAR(contact.penetration(4e-5 * k), 3.0 * exact.penetration(4e-5 * k), 1e-9);
    EXPECT_NEAR(contact.force(4e-5 * k), 3.0 * exact.force(4e-5 * k), 1e-4);
  }
}

// Hertz (1882): without damping the duration has a closed form in gamma functions.
TEST(HuntCrossley, WithoutDampingItLastsAsLongAsHertzSays) {
  const HuntCrossley law(kShell, 1.0, 0.004, 5.0);
  for (const double speed : {0.5, 5.0, 15.0}) {
    const double deepest = std::pow(1.25 * kShell * speed * speed / law.stiffness(), 0.4);
    const double quarter = 0.4 * std::tgamma(0.4) * std::tgamma(0.5) / std::tgamma(0.9);
    const auto contact = law.contact(speed);
    EXPECT_NEAR(contact.duration() / (2.0 * quarter * deepest / speed), 1.0, 1e-6);
    EXPECT_NEAR(contact.penetration(0.5 * contact.duration()) / deepest, 1.0, 1e-6);
  }
}

TEST(HuntCrossley, ImpossibleContactsAreRefused) {
  EXPECT_THROW(HuntCrossley(kShell, 0.0, 0.004, 5.0), std::invalid_argument);
  EXPECT_THROW(HuntCrossley(kShell, 1.1, 0.004, 5.0), std::invalid_argument);
  EXPECT_THROW(HuntCrossley(kShell, 0.9, 0.0, 5.0), std::invalid_argument);
  EXPECT_THROW(HuntCrossley(kShell, 0.9, 0.004, 0.0), std::invalid_argument);
  EXPECT_THROW(HuntCrossley(-1.0, 0.9, 0.004, 5.0), std::invalid_argument);
  EXPECT_THROW(HuntCrossley(kShell, 0.9, 0.004, 5.0, 0.5), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::physics
