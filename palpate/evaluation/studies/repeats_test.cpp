#include "palpate/evaluation/studies/repeats.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace palpate::evaluation::studies {
namespace {

TEST(Repeats, EachIsRunOnceOnAnyNumberOfThreads) {
  for (const int threads : {1, 2, 7}) {
    std::vector<std::atomic<int>> runs(101);
    repeat(runs.size(), {threads, {}}, [&](std::size_t i) { ++runs[i]; });
    for (const auto& n : runs) EXPECT_EQ(n, 1);
  }
}

TEST(Repeats, ProgressEndsAtOneAndComesFromTheCallingThread) {
  double last = -1.0;
  const auto here = std::this_thread::get_id();
  repeat(10,
         {2,
          [&](double share) {
            EXPECT_EQ(std::this_thread::get_id(), here);
            EXPECT_GE(share, last);
            last = share;
          }},
         [](std::size_t) {});
  EXPECT_EQ(last, 1.0);
}

TEST(Repeats, WhatARepeatThrowsArrivesHere) {
  std::atomic<int> runs{0};
  EXPECT_THROW(repeat(100000, {2, {}},
                      [&](std::size_t i) {
                        ++runs;
                        if (i == 3) throw std::runtime_error("no");
                        // Long enough for what is thrown to arrive before the other thread has run all the
                        // rest.
                        std::this_thread::sleep_for(std::chrono::milliseconds(1));
                      }),
               std::runtime_error);
  EXPECT_LT(runs, 100000);
}

TEST(Repeats, NothingToDoIsDone) {
  repeat(0, {}, [](std::size_t) { FAIL(); });
  EXPECT_THROW(repeat(1, {-1, {}}, [](std::size_t) {}), std::invalid_argument);
}

TEST(Repeats, SeedsDifferByPurposeAndIndex) {
  std::set<std::uint64_t> seeds;
  for (std::size_t i = 0; i < 100; ++i)
    for (const char* purpose : {"a", "b"})
      for (const std::uint64_t seed : {1u, 2u}) seeds.insert(repeat_seed(seed, purpose, i));
  EXPECT_EQ(seeds.size(), 400u);
}

}  // namespace
}  // namespace palpate::evaluation::studies
