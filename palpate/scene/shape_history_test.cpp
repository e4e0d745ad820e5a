#include "palpate/scene/shape_history.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

namespace palpate::scene {
namespace {

constexpr std::size_t kVertices = 500;
constexpr std::int64_t kStepNs = 8'000'000;

Instant<PhysicsClock> moment(std::int64_t ns) { return {Duration(ns)}; }

// All numbers of entry k are k, but for the first: its place tells torn copies.
std::vector<float> shape_of(std::int64_t k) {
  return std::vector<float>(kVertices * Shape::kFloatsPerVertex, static_cast<float>(k));
}

TEST(ShapeHistory, GivesWhatLiesBetweenAndTheNearestBeyond) {
  ShapeHistory history(kVertices);
  std::vector<float> out(kVertices * Shape::kFloatsPerVertex);
  EXPECT_FALSE(history.at(moment(0), out));
  for (int k = 1; k <= 200; ++k) ASSERT_TRUE(history.push(moment(k * kStepNs), shape_of(k)));
  const auto given = [&](std::int64_t ns) { return history.at(moment(ns), out)->ns(); };
  EXPECT_EQ(given(170 * kStepNs + kStepNs / 4), 170 * kStepNs + kStepNs / 4);
  for (const float x : out) ASSERT_FLOAT_EQ(x, 170.25F);
  EXPECT_EQ(given(171 * kStepNs), 171 * kStepNs);
  EXPECT_EQ(out.back(), 171.0F);
  EXPECT_EQ(given(300 * kStepNs), 200 * kStepNs);  // the newest
  EXPECT_EQ(out.front(), 200.0F);
  EXPECT_EQ(given(0), (201 - 63) * kStepNs);  // the oldest kept
  EXPECT_EQ(out.front(), 138.0F);
}

TEST(ShapeHistory, RefusesOtherSizesAndTimesThatDoNotIncrease) {
  ShapeHistory history(kVertices), none(0);
  EXPECT_TRUE(history.push(moment(5), shape_of(1)));
  EXPECT_FALSE(history.push(moment(5), shape_of(2)));
  EXPECT_FALSE(history.push(moment(6), std::vector<float>(6)));
  EXPECT_FALSE(none.push(moment(1), {}));
  std::vector<float> out(kVertices * Shape::kFloatsPerVertex), small(6);
  EXPECT_FALSE(history.at(moment(5), small));
  ASSERT_TRUE(history.at(moment(5), out));
  EXPECT_EQ(out.front(), 1.0F);
  EXPECT_THROW(ShapeHistory(Shape::kMaxVertices + 1), std::invalid_argument);
}

TEST(ShapeHistory, ReadersBesideAWriterSeeOnlyWholeShapes) {
  ShapeHistory history(kVertices);
  ASSERT_TRUE(history.push(moment(kStepNs), shape_of(1)));
  std::atomic<bool> seen_enough{false};
  std::atomic<std::int64_t> newest{1};
  std::thread writer([&] {
    for (std::int64_t k = 2; k < 4000 || !seen_enough; ++k) {
      history.push(moment(k * kStepNs), shape_of(k));
      newest = k;
    }
  });
  std::vector<float> out(kVertices * Shape::kFloatsPerVertex);
  int torn = 0;
  for (int looks = 0; looks < 100 || newest < 3000; ++looks) {
    // Near the end that is being overwritten, where a copy is torn first.
    const std::int64_t ns = std::max<std::int64_t>(1, newest - 60) * kStepNs + kStepNs / 2;
    const auto given = history.at(moment(ns), out);
    const double expected = given ? static_cast<double>(given->ns()) / static_cast<double>(kStepNs) : -1.0;
    torn += std::any_of(out.begin(), out.end(), [expected](float x) {
      return std::abs(static_cast<double>(x) - expected) > 1e-6 * expected;
    });
  }
  seen_enough = true;
  writer.join();
  EXPECT_EQ(torn, 0);
}

}  // namespace
}  // namespace palpate::scene
