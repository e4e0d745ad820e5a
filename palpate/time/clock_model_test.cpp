#include "palpate/time/clock_model.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "palpate/core/random.h"

namespace palpate::inline time {
namespace {

using Model = ClockModel<GraphicsClock, PhysicsClock>;
template <typename A, typename B>
concept Maps = requires(ClockModel<ArmClock, PhysicsClock> m, A a) {
  { m.to(a) } -> std::same_as<B>;
};
static_assert(Maps<Instant<ArmClock>, Instant<PhysicsClock>>);
static_assert(!Maps<Instant<TrackerClock>, Instant<PhysicsClock>>);

TEST(ClockModel, ReadsTheReferenceAtTheReferenceAndGainsItsDrift) {
  const Model model({seconds(100)}, {seconds(5)}, 80.0);
  EXPECT_EQ(model.to({seconds(100)}).ns(), 5'000'000'000);
  EXPECT_EQ(model.to({seconds(110)}).ns(), 15'000'000'000 + 800'000);
  EXPECT_EQ(model.to({seconds(90)}).ns(), -5'000'000'000 - 800'000);
}

TEST(ClockModel, BackUndoesToWithinANanosecondOverADay) {
  const Model model({seconds(12.5)}, {seconds(-3.75)}, -40.0);
  for (std::int64_t t = -1; t < 86'400; t += 997) {
    const Instant<GraphicsClock> there{seconds(static_cast<double>(t) + 0.123456789)};
    EXPECT_NEAR(static_cast<double>((model.back(model.to(there)) - there).count()), 0.0, 1.0);
  }
}

TEST(ClockModel, ItsUncertaintyGrowsAwayFromTheReference) {
  const Model model({seconds(10)}, {seconds(10)}, 0.0, Duration(1000), 2.0);
  EXPECT_EQ(model.uncertainty({seconds(10)}).count(), 1000);
  EXPECT_EQ(model.uncertainty({seconds(13)}).count(), 7000);
  EXPECT_EQ(model.uncertainty({seconds(7)}).count(), 7000);
}

// --- one-way stamps

using Estimator = ClockEstimator<TrackerClock, PhysicsClock>;

// A device whose clock has a known truth, with a smallest latency and exponential jitter on top.
struct Device {
  double offset_s, drift_ppm, latency_s, jitter_s;
  Random random{7, "device"};
  std::int64_t stamp_at(double t) const {
    return std::llround((t * (1.0 + drift_ppm * 1e-6) + offset_s) * 1e9);
  }
  void sample(Estimator& estimator, double t) {
    double late = latency_s - jitter_s * std::log(1.0 - random.uniform());
    if (random.chance(0.02)) late += 0.004 * random.uniform();  // the receiving thread was not scheduled
    estimator.add({Duration(stamp_at(t))}, {seconds(t + late)});
  }
  // What the model says for a sample taken at t, against the true time plus the smallest latency.
  double error(const Estimator& estimator, double t) const {
    return estimator.model().to({Duration(stamp_at(t))}).seconds() - (t + latency_s);
  }
};

TEST(ClockEstimator, GivesAnAnswerAfterTheFirstSample) {
  Estimator estimator;
  EXPECT_EQ(estimator.phase(), ClockPhase::empty);
  estimator.add({seconds(1000)}, {seconds(3)});
  EXPECT_EQ(estimator.model().to({seconds(1000)}).seconds(), 3.0);
  EXPECT_GE(estimator.model().uncertainty({seconds(1000)}), Duration(1'000'000));
}

TEST(ClockEstimator, FindsAPerfectClockToTheMicrosecond) {
  Device device{-3.75, -40.0, 0.010, 0.0};
  Estimator estimator;
  for (int i = 0; i < 2000; ++i)
    estimator.add({Duration(device.stamp_at(0.01 * i))}, {seconds(0.01 * i + 0.010)});
  // The prior on the drift (200 ppm) holds the slope back by less than its share; a microsecond is its size
  // here.
  EXPECT_NEAR(device.error(estimator, 20.0), 0.0, 1e-6);
  EXPECT_NEAR(estimator.model().drift_ppm(), 40.0, 0.1);
}

class EstimatorRuns : public testing::TestWithParam<std::tuple<double, double, double>> {};

TEST_P(EstimatorRuns, FollowsTheLowerEdgeThroughJitterAndDrift) {
  const auto [rate_hz, drift_ppm, jitter_s] = GetParam();
  Device device{12.5, drift_ppm, 0.010, jitter_s};
  Estimator estimator;
  int outside = 0, checked = 0;
  double worst = 0.0;
  for (int i = 0; i < 40 * rate_hz; ++i) {
    const double t = i / rate_hz;
    device.sample(estimator, t);
    if (t < 8.0) continue;
    const double error = device.error(estimator, t);
    worst = std::max(worst, std::abs(error));
    const double stated = to_seconds(estimator.model().uncertainty({Duration(device.stamp_at(t))}));
    outside += std::abs(error) > stated;
    ++checked;
  }
  // The best of n samples of an exponential delay comes jitter / n late: n is rate / 2 here. Three times that
  // leaves room for the scatter of the fit.
  EXPECT_LT(worst, 3.0 * jitter_s / (0.5 * rate_hz) + 3e-6);
  EXPECT_LT(outside, checked / 20);
  EXPECT_EQ(estimator.restarts(), 0);
}

INSTANTIATE_TEST_SUITE_P(RatesDriftsJitters, EstimatorRuns,
                         testing::Combine(testing::Values(30.0, 100.0, 1000.0),
                                          testing::Values(-40.0, 0.0, 80.0), testing::Values(50e-6, 500e-6)));

TEST(ClockEstimator, NeverJumpsOnceItTracks) {
  Device device{0.0, 35.0, 0.040, 1e-3};
  Estimator estimator;
  Instant<PhysicsClock> before{};
  for (int i = 0; i < 1000; ++i) {
    const double t = i / 30.0;
    const Instant<TrackerClock> stamp{Duration(device.stamp_at(t))};
    const Instant<PhysicsClock> old = estimator.model().to(stamp);
    const bool tracking = estimator.phase() == ClockPhase::tracking;
    device.sample(estimator, t);
    const Instant<PhysicsClock> now = estimator.model().to(stamp);
    if (tracking) {
      EXPECT_LE(std::abs((now - old).count()), 2) << "at " << t;  // rounding to nanoseconds, twice
    }
    if (i > 0) {
      EXPECT_GT(now, before);
    }
    before = now;
  }
}

TEST(ClockEstimator, ALateBeginningIsLeftAsSoonAsAnEarlierArrivalProvesIt) {
  Device device{0.0, 35.0, 0.040, 100e-6};
  Estimator estimator;
  for (int i = 0; i < 300; ++i) {
    const double t = i / 30.0;
    if (t < 4.0) {  // whoever draws the images is 4 to 6 ms behind
      estimator.add({Duration(device.stamp_at(t))}, {seconds(t + 0.044 + 0.002 * device.random.uniform())});
    } else {
      device.sample(estimator, t);
    }
    if (t > 3.0 && t < 3.9) {
      EXPECT_GT(device.error(estimator, t), 3e-3) << "nobody can know it yet";
    }
    // Slewed at 500 ppm this would take eight seconds.
    if (t > 4.2) {
      EXPECT_LT(std::abs(device.error(estimator, t)), 0.5e-3) << "at " << t;
    }
  }
  EXPECT_EQ(estimator.restarts(), 0) << "its clock was not set";
}

TEST(ClockEstimator, ASecondWithoutScheduleDoesNotLiftTheLine) {
  Device device{0.0, 20.0, 0.002, 20e-6};
  Estimator estimator;
  for (int i = 0; i < 3000; ++i) {
    const double t = 0.01 * i;
    if (t > 15.0 && t < 16.5) {  // everything of a second and a half arrives 30 ms late
      estimator.add({Duration(device.stamp_at(t))}, {seconds(t + 0.032)});
    } else {
      device.sample(estimator, t);
    }
    if (t > 8.0) {
      EXPECT_LT(std::abs(device.error(estimator, t)), 50e-6) << "at " << t;
    }
  }
}

TEST(ClockEstimator, NoticesADeviceClockThatStartsAnew) {
  Device device{500.0, 20.0, 0.002, 20e-6};
  Estimator estimator;
  for (int i = 0; i < 1000; ++i) device.sample(estimator, 0.01 * i);
  EXPECT_EQ(estimator.restarts(), 0);
  device.offset_s = -10.0;
  for (int i = 1000; i < 2000; ++i) device.sample(estimator, 0.01 * i);
  EXPECT_EQ(estimator.restarts(), 1);
  EXPECT_LT(std::abs(device.error(estimator, 20.0)), 20e-6);
  device.offset_s = 30.0;  // forwards: samples seem to come before they were taken
  for (int i = 2000; i < 3000; ++i) device.sample(estimator, 0.01 * i);
  EXPECT_EQ(estimator.restarts(), 2);
  EXPECT_LT(std::abs(device.error(estimator, 30.0)), 20e-6);
}

}  // namespace
}  // namespace palpate::inline time
