#include "palpate/device/marker_history.h"

#include <gtest/gtest.h>

#include "palpate/core/random.h"
#include "tests/chi_square.h"

namespace palpate::device {
namespace {

Instant<GraphicsClock> at(double s) { return Instant<GraphicsClock>::from_seconds(s); }

MarkerPose pose(double time, double x) {
  MarkerPose p;
  p.time = at(time);
  p.translation = {x, 0, 0};
  p.rotation = so3_exp({0, 0, x});
  return p;
}

TEST(MarkerHistory, InterpolatesBetweenNeighbours) {
  MarkerHistory history;
  history.add(pose(1.00, 0.0));
  history.add(pose(1.01, 0.1));
  const auto p = history.at(at(1.0025));
  ASSERT_TRUE(p.has_value());
  EXPECT_NEAR(p->translation.x(), 0.025, 1e-12);
  EXPECT_NEAR(so3_log(p->rotation).z(), 0.025, 1e-12);
}

TEST(MarkerHistory, GivesNothingOutsideWhatWasSeenOrAcrossAGap) {
  MarkerHistory history;
  EXPECT_FALSE(history.at(at(1.0)).has_value());
  history.add(pose(1.0, 0));
  history.add(pose(1.2, 0));
  EXPECT_FALSE(history.at(at(0.9)).has_value());
  EXPECT_FALSE(history.at(at(1.1)).has_value());
  EXPECT_FALSE(history.at(at(1.3)).has_value());
  EXPECT_TRUE(history.at(at(1.2)).has_value());
}

TEST(MarkerHistory, IgnoresLateAndRepeatedSamples) {
  MarkerHistory history;
  history.add(pose(1.00, 0));
  history.add(pose(1.01, 1));
  history.add(pose(1.005, 50));
  history.add(pose(1.01, 50));
  EXPECT_NEAR(history.at(at(1.005))->translation.x(), 0.5, 1e-12);
}

TEST(MarkerHistory, PredictsASteadyMotionExactly) {
  MarkerHistory history;
  const Vector3 rate(0.3, -0.8, 0.4), speed(0.2, 0.1, -0.3);
  const auto moved = [&](double t) {
    MarkerPose p;
    p.time = at(t);
    p.rotation = so3_exp(t * rate);
    p.translation = t * speed;
    return p;
  };
  for (int i = 0; i <= 10; ++i) history.add(moved(1.0 + 0.01 * i));
  for (const double t : {1.10, 1.12, 1.15}) {
    const auto p = history.predict(at(t));
    ASSERT_TRUE(p);
    EXPECT_LT(angle_between(p->rotation, so3_exp(t * rate)), 1e-9);
    EXPECT_LT((p->translation - t * speed).norm(), 1e-12);
  }
  EXPECT_FALSE(history.predict(at(1.3))) << "nobody knows where a head goes that was last seen 0.2 s ago";
  MarkerHistory two;
  two.add(moved(1.0)), two.add(moved(1.01));
  EXPECT_FALSE(two.predict(at(1.02)));
}

TEST(MarkerHistory, AHeadThatSpeedsUpIsFollowed) {
  const auto turn = [](double t) { return Vector3(0.0, 0.5 * t + 2.0 * t * t, 0.0); };  // 4 rad/s^2
  const auto shift = [](double t) { return Vector3(0.1 * t + 0.8 * t * t, 0.0, -t * t); };
  MarkerHistory history;
  for (int i = 0; i <= 6; ++i) {
    MarkerPose p;
    p.time = at(1.0 + 0.01 * i);
    p.rotation = so3_exp(turn(0.01 * i));
    p.translation = shift(0.01 * i);
    history.add(p);
  }
  const auto p = history.predict(at(1.09), MarkerHistory::Course::accelerating),
             steady = history.predict(at(1.09));
  ASSERT_TRUE(p && steady);
  EXPECT_LT(angle_between(p->rotation, so3_exp(turn(0.09))), 1e-9);
  EXPECT_LT((p->translation - shift(0.09)).norm(), 1e-9);
  EXPECT_GT(angle_between(steady->rotation, so3_exp(turn(0.09))), 5e-3);
}

void expect_stated_errors(MarkerHistory::Course course) {
  Random random(3, "marker prediction");
  const double sd = 0.0003;
  for (const double ahead : {0.0, 0.02, 0.05}) {
    double squares = 0.0, stated = 0.0;
    constexpr int kRuns = 2000;
    for (int run = 0; run < kRuns; ++run) {
      MarkerHistory history;
      for (int i = 0; i <= 6; ++i) {
        MarkerPose p;
        p.time = at(1.0 + 0.01 * i);
        p.translation = Vector3(random.normal(sd), 0, 0);
        p.covariance.diagonal().setConstant(sd * sd);
        history.add(p);
      }
      const auto p = history.predict(at(1.06 + ahead), course);
      ASSERT_TRUE(p);
      squares += p->translation.x() * p->translation.x();
      stated = p->covariance(3, 3);
    }
    EXPECT_TRUE(tests::is_chi_square(squares / stated, kRuns)) << ahead;
  }
}

TEST(MarkerHistory, APredictionsCovarianceGrowsAsItsErrorsDo) {
  expect_stated_errors(MarkerHistory::Course::steady);
  expect_stated_errors(MarkerHistory::Course::accelerating);
}

}  // namespace
}  // namespace palpate::device
