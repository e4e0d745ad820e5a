#include "palpate/sim/simulated_tracker.h"

#include <gtest/gtest.h>

#include "palpate/core/units.h"
#include "palpate/sim/truth.h"

namespace palpate::sim {
namespace {

config::WorldFile quiet() {
  auto world = config::reference_world();
  world.tracker.white_rms = 0.0;
  world.tracker.bias_rms = 0.0;
  world.tracker.dropout = 0.0;
  return world;
}

Vector3 reference_place(const config::WorldFile& world) {
  return world.tracker.optimal_distance *
         world.tracker.look_at.normalized();  // the cameras' middle is the origin
}

SeenBody facing_body(const config::WorldFile& world, double turned_away) {
  SeenBody body;
  body.leds = &world.tip_marker.leds;
  body.translation = world.tracker.look_at;
  const Vector3 towards = (-world.tracker.look_at).normalized();
  body.rotation = Quaternion(Eigen::AngleAxisd(turned_away, towards.unitOrthogonal())) *
                  rotation_between(body.normal, towards);
  return body;
}

TEST(SimulatedTracker, WhiteNoiseHasTheStatedRmsAtTheOptimalDistance) {
  auto world = quiet();
  world.tracker.white_rms = 0.165e-3;
  SimulatedTracker tracker(world, 1);
  const Vector3 place = reference_place(world);
  double sum = 0.0;
  constexpr int kRuns = 20000;
  for (int i = 0; i < kRuns; ++i) sum += (tracker.measure_led(place)->place - place).squaredNorm() / kRuns;
  EXPECT_NEAR(std::sqrt(sum), 0.165e-3, 0.02 * 0.165e-3);  // sd of the rms is about 0.5 %
}

TEST(SimulatedTracker, BiasHasTheStatedRmsOverManyTrackers) {
  auto world = quiet();
  world.tracker.bias_rms = 0.11e-3;
  double sum = 0.0;
  constexpr int kTrackers = 1500;
  for (int seed = 0; seed < kTrackers; ++seed)
    sum +=
        SimulatedTracker(world, static_cast<std::uint64_t>(seed)).bias(reference_place(world)).squaredNorm() /
        kTrackers;
  EXPECT_NEAR(std::sqrt(sum), 0.11e-3, 0.08 * 0.11e-3);  // one draw per tracker: sd of the rms about 2 %
}

TEST(SimulatedTracker, BiasIsFixedSmoothAndForgottenFarAway) {
  auto world = quiet();
  world.tracker.bias_rms = 0.11e-3;
  const double L = world.tracker.bias_correlation;
  double same = 0.0, near = 0.0, far = 0.0;
  constexpr int kTrackers = 600;
  for (int seed = 0; seed < kTrackers; ++seed) {
    SimulatedTracker tracker(world, static_cast<std::uint64_t>(seed));
    const Vector3 place = reference_place(world);
    const Vector3 here = tracker.bias(place);
    EXPECT_EQ(here, tracker.bias(place));
    EXPECT_NEAR((tracker.measure_led(place)->place - place - here).norm(), 0.0, 1e-12);
    same += here.squaredNorm();
    near += here.dot(tracker.bias(place + Vector3(L, 0, 0)));
    far += here.dot(tracker.bias(place + Vector3(4 * L, 0, 0)));
  }
  // Correlation exp(-d^2 / 2 L^2): 0.61 one length away, nothing at four; 600 draws leave about 0.03 of
  // doubt.
  EXPECT_NEAR(near / same, std::exp(-0.5), 0.10);
  EXPECT_NEAR(far / same, 0.0, 0.10);
}

TEST(SimulatedTracker, SwitchedOffItIsPerfect) {
  const auto world = quiet();
  SimulatedTracker tracker(world, 4);
  const auto body = facing_body(world, 0.3);
  const auto sample = tracker.measure({}, body);
  ASSERT_TRUE(sample.seen);
  EXPECT_LT((sample.translation - body.translation).norm(), 1e-10);
  EXPECT_LT(angle_between(sample.rotation, body.rotation), 1e-9);
  EXPECT_EQ(sample.covariance.norm(), 0.0);
}

TEST(SimulatedTracker, LedsTurnedAwayTooFarAreNotSeen) {
  const auto world = quiet();
  SimulatedTracker tracker(world, 4);
  EXPECT_EQ(tracker.measure({}, facing_body(world, radians_from_degrees(40))).leds, 6);
  const auto away = tracker.measure({}, facing_body(world, radians_from_degrees(75)));
  EXPECT_EQ(away.leds, 0);
  EXPECT_FALSE(away.seen);
}

TEST(SimulatedTracker, DropoutHidesThatShareOfLedsAndBelowThreeTheBody) {
  auto world = quiet();
  world.tracker.dropout = 0.5;
  SimulatedTracker tracker(world, 11);
  const auto body = facing_body(world, 0.0);
  int leds = 0, frames = 0;
  for (int i = 0; i < 4000; ++i) {
    const auto sample = tracker.measure({}, body);
    leds += sample.leds;
    ++frames;
    if (sample.leds < 3) {
      EXPECT_FALSE(sample.seen);
    }
  }
  EXPECT_NEAR(leds / (6.0 * frames), 0.5, 0.02);  // sd 0.003
}

TEST(SimulatedTracker, BelievesItsWhiteNoiseAndNotItsBias) {
  auto world = quiet();
  world.tracker.white_rms = 0.2e-3;
  SimulatedTracker white(world, 2);
  const auto alone = white.measure({}, facing_body(world, 0.2));
  world.tracker.bias_rms = 0.5e-3;
  SimulatedTracker biased(world, 2);
  const auto with_bias = biased.measure({}, facing_body(world, 0.2));
  EXPECT_GT(alone.covariance.trace(), 0.0);
  // The same noise at slightly displaced LEDs: the covariance hardly changes.
  EXPECT_NEAR(with_bias.covariance.trace() / alone.covariance.trace(), 1.0, 0.05);
}

TEST(SimulatedTracker, MarkersOfTheReferenceWorldFaceTheTrackerInUse) {
  const auto& world = config::reference_world();
  const auto truth = draw_truth(world, 1);
  // At reset the stylus has the base's axes.
  const Vector3 normal = truth.X_world_base.rotation * truth.X_tip_marker.rotation * tip_marker_normal();
  const Vector3 towards = (-truth.X_world_base.translation).normalized();
  EXPECT_LT(std::acos(normal.dot(towards)), radians_from_degrees(15));
}

}  // namespace
}  // namespace palpate::sim
