#include "palpate/calibration/touched_landmarks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "palpate/core/random.h"
#include "palpate/core/units.h"
#include "tests/chi_square.h"

namespace palpate::calibration {
namespace {

// A table that lies flat and a wall behind it.
std::vector<rig::SurfaceCalibration> room() {
  rig::SurfaceCalibration table;
  table.name = "table";
  table.width = table.height = 1.0;
  rig::SurfaceCalibration wall = table;
  wall.name = "wall";
  wall.X_world_rectangle = {so3_exp(Vector3(std::numbers::pi / 2, 0, 0)), Vector3(0, 1, 0)};
  return {table, wall};
}

TEST(TouchedLandmarks, EachLiesOnItsSurfaceAtTheMeanOfItsTouches) {
  const std::vector<LandmarkTouch> touches{
      {"a", {0.2, 0.3, 0.001}}, {"b", {0.4, 0.999, 0.5}}, {"a", {0.202, 0.3, -0.001}}};
  const auto fit = landmarks_from_touches(touches, room(), {.touch = {0.01, 1e9}, .diameter = 0.012});
  ASSERT_TRUE(fit) << fit.error().message;
  const auto& found = fit->value;
  EXPECT_EQ(found.labels, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(found.surface, (std::vector<std::string>{"table", "wall"}));
  EXPECT_EQ(found.touches, (std::vector<int>{2, 1}));
  EXPECT_LT((found.landmarks[0].place.m - Vector3(0.201, 0.3, 0)).norm(), 1e-12);
  EXPECT_LT((found.landmarks[0].normal - Vector3::UnitZ()).norm(), 1e-12);
  EXPECT_LT((found.landmarks[1].normal + Vector3::UnitY()).norm(), 1e-12);
  EXPECT_EQ(found.landmarks[1].diameter, 0.012);
  EXPECT_NEAR(found.distance[1], 0.001, 1e-12);
  EXPECT_NEAR(found.landmarks[0].covariance(0, 0), 0.5e-4, 1e-12);  // two touches of 10 mm each
  EXPECT_NEAR(found.landmarks[1].covariance(2, 2), 1e-4, 1e-12);
}

TEST(TouchedLandmarksStatistics, AShakyHandIsSeenInTheScatterAndTheTrackersPartIsNotAveragedAway) {
  constexpr double kShake = 0.001, kTracker = 0.0004;
  double square = 0.0, stated = 0.0;
  constexpr int kRuns = 200;
  for (int run = 0; run < kRuns; ++run) {
    Random random(static_cast<std::uint64_t>(run + 1), "touches");
    std::vector<LandmarkTouch> touches;
    for (int k = 0; k < 8; ++k) {
      const Vector3 place(0.1 * k, 0.2, 0.0);
      const Vector3 shared(random.normal(kTracker), random.normal(kTracker), random.normal(kTracker));
      for (int n = 0; n < 4; ++n)
        touches.push_back(
            {std::to_string(k),
             place + shared + Vector3(random.normal(kShake), random.normal(kShake), random.normal(kShake)),
             kTracker * kTracker * Matrix3::Identity()});
    }
    const auto fit = landmarks_from_touches(touches, room(), {});
    ASSERT_TRUE(fit) << fit.error().message;
    for (int k = 0; k < 8; ++k) {
      const auto& landmark = fit->value.landmarks[static_cast<std::size_t>(k)];
      square += (landmark.place.m - Vector3(0.1 * k, 0.2, 0.0)).squaredNorm();
      stated += landmark.covariance.trace();
    }
  }
  // The hand's part, 0.25 of 0.41 mm^2, is known by 72 freedoms a run; the tracker's is given.
  EXPECT_TRUE(
      tests::is_sum_of_f(24 * kRuns * square / stated, 1, 24 * kRuns, 72 * kRuns * std::pow(0.41 / 0.25, 2)));
}

TEST(TouchedLandmarks, WhatIsKnownOfTheHandIsPooledWithTheScatter) {
  // Two touches of one dot, 2 mm apart along one axis: 2e-6 m^2 over three freedoms.
  const std::vector<LandmarkTouch> touches{{"a", {0.2, 0.3, 0.001}}, {"a", {0.2, 0.3, -0.001}}};
  const auto unknown = landmarks_from_touches(touches, room(), {.touch = {0.0, 0.0}});
  const auto known = landmarks_from_touches(touches, room(), {.touch = {0.0005, 9.0}});
  ASSERT_TRUE(unknown && known);
  EXPECT_NEAR(unknown->value.touch.sd, std::sqrt(2e-6 / 3), 1e-12);
  EXPECT_NEAR(known->value.touch.sd, std::sqrt((9 * 0.25e-6 + 2e-6) / 12), 1e-12);
  EXPECT_EQ(known->value.touch.freedoms, 12.0);
  // Once each: nothing but what was known.
  const auto once = landmarks_from_touches({touches[0]}, room(), {.touch = {0.0005, 9.0}});
  EXPECT_NEAR(once->covariance(0, 0), 0.25e-6, 1e-15);
}

TEST(TouchedLandmarks, ImpossibleInputIsRefused) {
  const LandmarkTouch good{"a", {0.2, 0.3, 0.0}};
  EXPECT_FALSE(landmarks_from_touches({}, room()));
  EXPECT_NE(landmarks_from_touches({good}, {}).error().message.find("calibrate surface first"),
            std::string::npos);
  const auto apart = landmarks_from_touches({good, {"a", {0.3, 0.3, 0.0}}}, room());
  ASSERT_FALSE(apart);
  EXPECT_NE(apart.error().message.find("label two dots differently"), std::string::npos);
  EXPECT_FALSE(landmarks_from_touches({{"a", {0.2, std::nan(""), 0.0}}}, room()));
}

}  // namespace
}  // namespace palpate::calibration
