#include "palpate/physics/flight.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "palpate/core/csv.h"
#include "palpate/core/random.h"

namespace palpate::physics {
namespace {

BouncePlane floor_at(double height, const Bounce& law) {
  BouncePlane plane;
  plane.point = {0, height, 0};
  plane.law = law;
  return plane;
}

TEST(Flight, ADroppedBallReturnsToESquaredOfItsHeight) {
  const auto model = BallModel::paper();
  const auto plane = floor_at(0.02, {0.93, 0.0});
  BallState ball{{0, 1.02, 0}, Vector3::Zero(), Vector3::Zero()};
  const double fall = std::sqrt(2.0 / 9.81), rise = 0.93 * fall;
  EXPECT_EQ(advance(model, {&plane, 1}, ball, fall + rise), 1);
  EXPECT_NEAR(ball.position.y() - 0.02, 0.93 * 0.93, 1e-12);
  EXPECT_NEAR(ball.velocity.y(), 0.0, 1e-11);
}

TEST(Flight, ABallAtRestStaysOnItsPlane) {
  const auto plane = floor_at(0.0, {0.5, 0.0});
  BallState ball{{0, 0.1, 0}, Vector3::Zero(), Vector3::Zero()};
  advance(BallModel::paper(), {&plane, 1}, ball, 1.0);
  EXPECT_GT(ball.position.y(), -1e-3);
}

TEST(Flight, BeyondTheRimThereIsNoTable) {
  const std::array<Vector3, 4> corners{Vector3(-1, 0, 1), Vector3(1, 0, 1), Vector3(1, 0, -1),
                                       Vector3(-1, 0, -1)};
  const auto plane = bounce_plane(corners, 0.02, {0.9, 0.0});
  EXPECT_NEAR((plane.normal - Vector3::UnitY()).norm(), 0.0, 1e-15);
  BallState on{{0.9, 0.1, 0.9}, {0, -3, 0}, Vector3::Zero()}, off = on;
  off.position.x() = 1.1;
  EXPECT_EQ(advance(BallModel(), {&plane, 1}, on, 0.1), 1);
  EXPECT_EQ(advance(BallModel(), {&plane, 1}, off, 0.1), 0);
}

TEST(Flight, PerfectObservationsGiveTheFlightBackThroughABounce) {
  Random random(1, "flight/perfect");
  const BallModel model;
  const auto plane = floor_at(0.0, {0.93, 0.25});
  for (int k = 0; k < 20; ++k) {
    const BallState truth{{0, random.uniform(0.2, 0.4), 0},
                          {random.uniform(-1, 1), random.uniform(-2, 1), random.uniform(2, 4)},
                          Vector3::Zero()};
    std::vector<SeenBall> seen;
    for (int i = 0; i < 14; ++i) {
      BallState ball = truth;
      advance(model, {&plane, 1}, ball, i / 30.0, 0.001);
      seen.push_back({i / 30.0, ball.position});
    }
    const auto fit = fit_flight(model, {&plane, 1}, seen);
    ASSERT_TRUE(fit);
    EXPECT_NEAR((fit->state.position - truth.position).norm(), 0.0,
                1e-4);  // the prediction steps by 5 ms, the truth by 1
    EXPECT_NEAR((fit->state.velocity - truth.velocity).norm(), 0.0, 1e-3);
  }
}

TEST(Flight, ObservationsNoBallCanExplainAreRefused) {
  const auto refusal = [](const std::vector<SeenBall>& seen) {
    const auto fit = fit_flight(BallModel{}, {}, seen);
    return fit ? std::string("none") : fit.error().message;
  };
  const std::vector<SeenBall> together{{0.0, {0, 0, 1}}, {2e-301, {16, 0, 1}}, {1.6e-19, {0, 0, 0}}};
  EXPECT_NE(refusal(together).find("observation 2 comes 2e-301 s after"), std::string::npos)
      << refusal(together);
  const std::vector<SeenBall> leaps{
      {0.0, {0, 0, 1}}, {1e-6, {900, 0, 1}}, {2e-6, {-900, 0, 1}}, {5.0, {900, 900, 900}}};
  const auto fit = fit_flight(BallModel{}, {}, leaps);
  EXPECT_TRUE(!fit || std::isfinite(fit->rms)) << fit->rms;
}

TEST(Flight, TooFewOrUnsortedObservationsAreRefused) {
  const BallModel model;
  std::vector<SeenBall> seen{{0, {0, 1, 0}}, {0.01, {0, 1, 0}}};
  EXPECT_FALSE(fit_flight(model, {}, seen));
  seen.push_back({0.005, {0, 1, 0}});
  EXPECT_FALSE(fit_flight(model, {}, seen));
}

TEST(Flight, SpinIsFoundFromAWholeFlightThroughABounce) {
  Random random(3, "flight/spin");
  const BallModel model;
  const auto plane = floor_at(0.0, {0.93, 0.25});
  for (int k = 0; k < 20; ++k) {
    BallState truth{{0, 0.5, 0}, {random.uniform(-1, 1), 1.5, random.uniform(4, 6)}, Vector3::Zero()};
    truth.spin = {random.uniform(-200, 200), random.uniform(-100, 100), 0.0};  // across the path
    std::vector<SeenBall> exact, noisy;
    for (int i = 0; i < 140; ++i) {
      BallState ball = truth;
      advance(model, {&plane, 1}, ball, i / 180.0, 0.001);
      exact.push_back({i / 180.0, ball.position});
      const Vector3 off(random.normal(0.003), random.normal(0.003), random.normal(0.003));
      noisy.push_back({i / 180.0, ball.position + off});
    }
    const auto fit = fit_flight_and_spin(model, {&plane, 1}, exact);
    ASSERT_TRUE(fit);
    EXPECT_LT(fit->rms, 2e-4);
    // What is expected of a spin pulls by the little that three millimetres are beside a whole flight.
    EXPECT_NEAR((fit->state.spin - truth.spin).head<2>().norm(), 0.0, 8.0);
    const auto rough = fit_flight_and_spin(model, {&plane, 1}, noisy);
    ASSERT_TRUE(rough);
    EXPECT_NEAR((rough->state.spin - truth.spin).head<2>().norm(), 0.0, 40.0);
    EXPECT_LT(rough->rms, 0.0035);
    EXPECT_GT(fit_flight(model, {&plane, 1}, noisy)->rms, rough->rms);
  }
}

TEST(Flight, ASpinNobodyCouldSeeStaysNearNone) {
  std::vector<SeenBall> seen;
  const BallModel model;
  BallState ball{{0, 1, 0}, {0, 0, 5}, Vector3::Zero()};
  for (int i = 0; i < 10; ++i) {
    seen.push_back({i / 180.0, ball.position});
    ball = fly(model, ball, 1.0 / 180.0);
  }
  const auto fit = fit_flight_and_spin(model, {}, seen);
  ASSERT_TRUE(fit);
  EXPECT_LT(fit->state.spin.norm(), 60.0);
  EXPECT_FALSE(fit_flight_and_spin(model, {}, {seen.data(), 5}));
}

// Real flights (data/flights): what the first 100 ms say about the ball 300 ms later.
std::vector<double> errors_on_recordings(const BallModel& air, const std::string& set, int flights) {
  BallModel model = air;
  model.gravity = {0, 0, -9.81};
  BouncePlane plane;
  plane.point = {0, 0, 0.760};
  plane.normal = Vector3::UnitZ();
  plane.law = {0.925, 0.25};
  std::vector<double> errors;
  for (int k = 0; k < flights; ++k) {
    const auto table = read_csv(std::string(PALPATE_DATA_DIR) + "/flights/" + set + (k < 5 ? "_00" : "_0") +
                                std::to_string(2 * k) + ".csv");
    if (!table) {
      ADD_FAILURE() << table.error().message;
      return {};
    }
    std::vector<SeenBall> all, window;
    for (const auto& row : table->rows) {
      all.push_back({row[0], {row[1], row[2], row[3]}});
      if (row[0] <= table->rows[0][0] + 0.1) window.push_back(all.back());
    }
    const auto fit = fit_flight(model, {&plane, 1}, window);
    if (!fit) {
      ADD_FAILURE() << fit.error().message;
      return {};
    }
    const double t = all[0].time + 0.4;
    const auto nearest = *std::min_element(all.begin(), all.end(), [&](const auto& a, const auto& b) {
      return std::abs(a.time - t) < std::abs(b.time - t);
    });
    BallState ball = fit->state;
    advance(model, {&plane, 1}, ball, nearest.time - fit->time);
    errors.push_back((ball.position - nearest.position).norm());
  }
  std::sort(errors.begin(), errors.end());
  return errors;
}

TEST(Flight, RecordedFlightsArePredictedSeveralTimesBetterWithAir) {
  const auto paper = errors_on_recordings(BallModel::paper(), "no_spin_robot_simple", 8);
  const auto full = errors_on_recordings(BallModel(), "no_spin_robot_simple", 8);
  ASSERT_EQ(full.size(), 8u);
  EXPECT_LT(full[4], 0.025);  // an independent prototype had a median of 17 mm on 24 such flights
  EXPECT_LT(full[4], 0.4 * paper[4]);
  for (const auto* set : {"mn5008_topspin", "mn5008_backspin"}) {
    const auto with_air = errors_on_recordings(BallModel(), set, 2),
               without = errors_on_recordings(BallModel::paper(), set, 2);
    ASSERT_EQ(with_air.size(), 2u);
    EXPECT_LT(with_air[1], without[0]) << "even unknown spin leaves drag worth having";
  }
}

}  // namespace
}  // namespace palpate::physics
