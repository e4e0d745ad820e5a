#include "palpate/scene/step_reader.h"

#include <gtest/gtest.h>

#include <random>

#include "palpate/scene/scene_history.h"

namespace palpate::scene {
namespace {

using Time = StepReader::Time;

// A physics loop of 1 kHz whose steps can be recognised, its history, and a reader far from both.
class ReadLoop {
 public:
  explicit ReadLoop(unsigned seed = 1) : random_(seed) {}

  double late_share = 0.0, left_out_share = 0.0, loss = 0.0;

  // A millisecond: a step, as a rule on the grid, and what the reader asks.
  void pass() {
    now_ += Duration(1'000'000);
    SceneState step;
    step.time =
        chance(late_share) ? now_ + Duration(1 + static_cast<std::int64_t>(random_() % 999'998)) : now_;
    step.tick = ++tick_;
    step.body_count = 1;
    step.bodies[0].position = {std::sin(now_.seconds()), 0.0, 0.1};
    step.counters[0] = static_cast<std::int32_t>(tick_);
    if (!chance(left_out_share) && history.push(step)) pushed.push_back(step);
  }
  void ask() {
    reader.look();
    while (const auto time = reader.question(now_.since_epoch)) {
      ++questions;
      if (!chance(loss)) reader.answer(*time, history.at(*time), read);
    }
  }

  SceneHistory history{Vector3(0, -9.81, 0)};
  StepReader reader;
  std::vector<SceneState> pushed, read;
  std::uint64_t questions = 0;

 private:
  bool chance(double share) { return std::uniform_real_distribution(0.0, 1.0)(random_) < share; }

  std::mt19937 random_;
  Time now_ = Time::from_seconds(5.0);
  std::uint64_t tick_ = 0;
};

// What was read is what the history was given, from the first read on; returns how many at the end are still to come.
std::size_t expect_read(const ReadLoop& loop) {
  EXPECT_FALSE(loop.read.empty());
  if (loop.read.empty()) return loop.pushed.size();
  const auto begin = std::find_if(loop.pushed.begin(), loop.pushed.end(),
                                  [&](const SceneState& step) { return step.tick == loop.read[0].tick; });
  const auto ahead = static_cast<std::size_t>(loop.pushed.end() - begin);
  EXPECT_LE(loop.read.size(), ahead);
  for (std::size_t i = 0; i < std::min(ahead, loop.read.size()); ++i) {
    const SceneState& step = begin[static_cast<std::ptrdiff_t>(i)];
    const bool same = step.tick == loop.read[i].tick && step.time == loop.read[i].time &&
                      step.counters == loop.read[i].counters &&
                      step.bodies[0].position == loop.read[i].bodies[0].position;
    EXPECT_TRUE(same) << i << ": tick " << loop.read[i].tick << " for " << step.tick;
    if (!same) break;
  }
  return ahead - loop.read.size();
}

TEST(StepReader, ReadsEveryStepOfALoopOnItsGridWithAQuestionEach) {
  ReadLoop loop;
  for (int i = 0; i < 3000; ++i) {
    loop.pass();
    if (i % 5 == 4) loop.ask();
  }
  EXPECT_EQ(expect_read(loop), 0u);
  EXPECT_GT(loop.read.size(), 2900u);
  EXPECT_LT(loop.questions, 3700u);
}

TEST(StepReader, FindsStepsThatBeganLateToTheNanosecond) {
  ReadLoop loop;
  loop.late_share = 0.03;
  for (int i = 0; i < 3000; ++i) {
    loop.pass();
    if (i % 5 == 4) loop.ask();
  }
  EXPECT_EQ(expect_read(loop), 0u);
  EXPECT_GT(std::count_if(loop.read.begin(), loop.read.end(),
                          [](const SceneState& step) { return step.time.ns() % 1'000'000 != 0; }),
            50);
}

TEST(StepReader, FindsTheGridWhereItBeganOffIt) {
  ReadLoop loop;
  loop.late_share = 1.0;
  for (int i = 0; i < 10; ++i) loop.pass();
  loop.ask();
  loop.late_share = 0.0;
  for (int i = 0; i < 2000; ++i) {
    loop.pass();
    if (i % 5 == 4) loop.ask();
  }
  EXPECT_EQ(expect_read(loop), 0u);
  EXPECT_LT(loop.questions, 3000u);
}

TEST(StepReader, WhatTheHistoryDoesNotHaveShowsInTheTicks) {
  ReadLoop loop;
  loop.left_out_share = 0.2;
  for (int i = 0; i < 2000; ++i) {
    loop.pass();
    if (i % 5 == 4) loop.ask();
  }
  EXPECT_EQ(expect_read(loop), 0u);
  EXPECT_LT(loop.read.size(), 1800u);
}

TEST(StepReader, LostQuestionsAndAnswersAreAskedAgain) {
  ReadLoop loop;
  loop.loss = 0.2;
  loop.late_share = 0.01;
  for (int i = 0; i < 5000; ++i) {
    loop.pass();
    loop.ask();
  }
  loop.loss = 0.0;
  for (int i = 0; i < 1000; ++i) {
    loop.pass();
    loop.ask();
  }
  EXPECT_EQ(expect_read(loop), 0u);
  EXPECT_GT(loop.read.size(), 4000u);  // the first answer may be lost, more than once
}

TEST(StepReader, AfterAPauseTheHistoryHasWhatCameMeanwhile) {
  ReadLoop loop;
  loop.pass();
  loop.ask();
  for (int i = 0; i < 7000; ++i) loop.pass();
  for (int i = 0; i < 300; ++i) loop.ask();
  EXPECT_EQ(expect_read(loop), 0u);
  EXPECT_EQ(loop.read.size(), 7001u);
}

TEST(StepReader, WhereTheHistoryHasGoneOnItGoesOnWithTheNewest) {
  ReadLoop loop;
  loop.pass();
  loop.ask();
  for (int i = 0; i < 10'000; ++i) loop.pass();
  for (int i = 0; i < 10; ++i) loop.ask();
  ASSERT_EQ(loop.read.size(), 2u);
  EXPECT_EQ(loop.read[1].tick, 10'001u);
  for (int i = 0; i < 100; ++i) loop.pass();
  for (int i = 0; i < 10; ++i) loop.ask();
  EXPECT_EQ(loop.read.size(), 102u);
}

TEST(StepReader, AskedNothingWhereThereIsNoStep) {
  ReadLoop loop;
  for (int i = 0; i < 5; ++i) loop.ask();
  EXPECT_TRUE(loop.read.empty());
  EXPECT_EQ(loop.questions, 5u);
}

TEST(StepReader, AnswersThatNoHistoryGivesDoNoHarm) {
  std::mt19937_64 random(3);
  std::size_t asked = 0, read = 0;
  for (int server = 0; server < 300; ++server) {
    StepReader reader;
    std::vector<SceneState> steps;
    for (int i = 0; i < 100; ++i) {
      reader.look();
      while (const auto time = reader.question(Duration(1'000'000 * i))) {
        if (++asked % 40 == 0) break;
        StateAnswer answer;
        answer.kind = static_cast<AnswerKind>(random() % 5);
        answer.state.tick = random() % 3 == 0 ? random() : static_cast<std::uint64_t>(i);
        answer.state.time = {Duration(static_cast<std::int64_t>(random() >> (4 + random() % 60)))};
        reader.answer(*time, answer, steps);
      }
    }
    read += steps.size();
  }
  EXPECT_GT(read, 300u);
  EXPECT_LE(read, asked);
}

}  // namespace
}  // namespace palpate::scene
