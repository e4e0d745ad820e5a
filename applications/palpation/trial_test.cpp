#include "applications/palpation/trial.h"

#include <gtest/gtest.h>

#include "tests/allocation_count.h"

namespace palpate::applications::palpation {
namespace {

constexpr double kMs = 1e-3;

// A trial on a flat organ whose top is at y = 0.05, with one nodule under (0, 0).
struct TrialBench {
  std::vector<HiddenNodule> nodules;
  Trial trial;
  TipOnOrgan tip;

  explicit TrialBench(const TrialRules& rules = {}) : trial(rules, 0.05) {
    nodules.resize(1);
    nodules[0].above = {0.0, 0.05, 0.0};
    trial.prepare(nodules);
    tip.seen = true;
    lift(0.0, 0.0);
    trial.step(kMs, tip);
  }
  void lift(double x, double z, double height = 0.02) {
    tip.tip = {x, 0.05 + height, z};
    tip.depth = tip.force = 0.0;
  }
  void press(double x, double z, double depth = 0.004, double force = 0.4) {
    tip.tip = {x, 0.056 - depth, z};
    tip.foot = {x, 0.05, z};
    tip.depth = depth;
    tip.force = force;
  }
  void go_on(double for_s) {
    for (int i = 0; i < static_cast<int>(for_s / kMs + 0.5); ++i) trial.step(kMs, tip);
  }
};

TEST(Trial, BeginsWithTheFirstTouchAndEndsWhenTheStylusIsPutAway) {
  TrialBench bench;
  bench.go_on(1.0);
  EXPECT_EQ(bench.trial.phase(), TrialPhase::ready);
  bench.press(0.003, 0.0);
  bench.go_on(1.5);
  EXPECT_EQ(bench.trial.phase(), TrialPhase::searching);
  ASSERT_EQ(bench.trial.marks().size(), 1u) << "held still for longer than it takes";
  bench.lift(0.0, 0.0, Trial::kAway_m + 0.01);
  bench.go_on(0.5);
  EXPECT_EQ(bench.trial.phase(), TrialPhase::searching);
  bench.go_on(0.5);
  EXPECT_EQ(bench.trial.phase(), TrialPhase::shown);
  EXPECT_EQ(bench.trial.score().found, 1);
  EXPECT_NEAR(bench.trial.score().median_error(), 0.003, 1e-12);
  EXPECT_NEAR(bench.trial.searched_s(), 1.5 + Trial::kAway_s, 2 * kMs);
}

// A person who takes the arm over while the program presses would else see the search end with the first lift.
TEST(Trial, ATipThatRestsOnTheOrganFromBeforeBeginsNothing) {
  TrialBench bench;
  bench.press(0.003, 0.0);
  bench.go_on(0.5);
  ASSERT_EQ(bench.trial.phase(), TrialPhase::searching);
  bench.trial.prepare(bench.nodules);
  bench.go_on(2.0);
  EXPECT_EQ(bench.trial.phase(), TrialPhase::ready);
  bench.lift(0.0, 0.0, Trial::kAway_m + 0.01);
  bench.go_on(2.0);
  EXPECT_EQ(bench.trial.phase(), TrialPhase::ready);
  bench.press(0.003, 0.0);
  bench.go_on(kMs);
  EXPECT_EQ(bench.trial.phase(), TrialPhase::searching);
}

TEST(Trial, IsOverWhenItsTimeIs) {
  TrialBench bench({.seconds = 2.0});
  bench.press(0.0, 0.0, 0.001);
  bench.go_on(1.99);
  EXPECT_EQ(bench.trial.phase(), TrialPhase::searching);
  bench.go_on(0.02);
  EXPECT_EQ(bench.trial.phase(), TrialPhase::shown);
  EXPECT_EQ(bench.trial.score().missed(), 1);
}

TEST(Trial, AHandThatMovesOnMarksNothingAndOneThatStaysMarksOnce) {
  TrialBench bench;
  for (int i = 0; i < 3000; ++i) {
    bench.press(0.02 * kMs * i, 0.0);  // 20 mm/s
    bench.trial.step(kMs, bench.tip);
  }
  EXPECT_TRUE(bench.trial.marks().empty());
  bench.go_on(5.0);
  EXPECT_EQ(bench.trial.marks().size(), 1u);
}

TEST(Trial, ALightTouchMarksNothing) {
  TrialBench bench;
  bench.press(0.0, 0.0, 0.001);
  bench.go_on(3.0);
  EXPECT_TRUE(bench.trial.marks().empty());
}

TEST(Trial, MarkingAMarkAgainTakesItBack) {
  TrialBench bench;
  for (const double x : {0.0, 0.02, 0.04}) {
    bench.press(x, 0.0);
    bench.go_on(1.2);
    bench.lift(x, 0.0);
    bench.go_on(0.1);
  }
  ASSERT_EQ(bench.trial.marks().size(), 3u);
  bench.press(0.0, 0.003);
  bench.go_on(1.2);
  ASSERT_EQ(bench.trial.marks().size(), 2u);
  EXPECT_EQ(bench.trial.marks()[0].x(), 0.02);
  EXPECT_EQ(bench.trial.marks()[1].x(), 0.04);
}

TEST(Trial, AskingMarksWhereThereIsATouchAndEndsWhereThereIsNone) {
  TrialBench bench;
  bench.trial.ask();
  EXPECT_EQ(bench.trial.phase(), TrialPhase::ready);
  bench.press(0.001, 0.0);
  bench.go_on(0.1);
  bench.trial.ask();
  EXPECT_EQ(bench.trial.marks().size(), 1u);
  bench.lift(0.0, 0.0);
  bench.go_on(0.1);
  bench.trial.ask();
  EXPECT_EQ(bench.trial.phase(), TrialPhase::shown);
  EXPECT_FALSE(bench.trial.next_wanted());
  bench.trial.ask();
  EXPECT_TRUE(bench.trial.next_wanted());
}

TEST(Trial, CountsHardPressesOnceEachAndTheWay) {
  TrialBench bench({.hard_n = 1.0});
  for (const double force : {0.5, 1.2, 0.9, 1.3, 0.5, 1.1}) {  // 0.9 is not let up yet
    bench.press(0.0, 0.0, 0.004, force);
    bench.go_on(0.01);
  }
  EXPECT_EQ(bench.trial.hard_presses(), 2);
  const double before = bench.trial.path();
  for (int i = 0; i <= 100; ++i) {
    bench.press(1e-4 * i, 0.0);
    bench.trial.step(kMs, bench.tip);
  }
  EXPECT_NEAR(bench.trial.path() - before, 0.010, 1e-9);
}

TEST(Trial, AllMarksAreTakenAndAStepAllocatesNothing) {
  TrialBench bench({.seconds = 100.0});
  const std::size_t before = allocations();
  for (std::size_t i = 0; i < kMostMarks + 2; ++i) {
    bench.press(0.01 * static_cast<double>(i), 0.0);
    bench.go_on(1.2);
  }
  bench.lift(0.0, 0.0, 0.2);
  bench.go_on(1.0);
  EXPECT_EQ(allocations() - before, 0u);
  EXPECT_EQ(bench.trial.marks().size(), kMostMarks);
  EXPECT_EQ(bench.trial.phase(), TrialPhase::shown);
  EXPECT_EQ(bench.trial.score().false_alarms, static_cast<int>(kMostMarks) - 1);
}

}  // namespace
}  // namespace palpate::applications::palpation
