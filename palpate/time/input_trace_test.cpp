#include "palpate/time/input_trace.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "palpate/time/input_playback.h"
#include "palpate/time/triple_buffer.h"

namespace palpate::inline time {
namespace {

TEST(InputTrace, WithoutOneAValueIsHandedOn) {
  EXPECT_EQ(InputTrace::pass(7), 7u);
  EXPECT_EQ(InputTrace::current(), nullptr);
}

TEST(InputTrace, WritesWhatPassesAndGivesItBack) {
  InputTrace written;
  written.write();
  {
    const InputTrace::Scope scope(&written);
    EXPECT_EQ(InputTrace::pass(3), 3u);
    EXPECT_EQ(InputTrace::pass(5), 5u);
  }
  EXPECT_EQ(InputTrace::pass(9), 9u);
  EXPECT_TRUE(written.exact());
  InputPlayback playback(1);
  InputTrace played;
  played.play(written.values(), playback);
  {
    const InputTrace::Scope scope(&played);
    EXPECT_EQ(InputTrace::pass(100), 3u);
    EXPECT_FALSE(played.exact()) << "one is left";
    EXPECT_EQ(InputTrace::pass(100), 5u);
    EXPECT_TRUE(played.exact());
    InputTrace::pass(100);
    EXPECT_FALSE(played.exact()) << "one too many";
  }
}

TEST(InputTrace, SaysWhereThereWasNoRoom) {
  InputTrace trace;
  trace.write();
  const InputTrace::Scope scope(&trace);
  for (std::size_t i = 0; i < InputTrace::kMost; ++i) InputTrace::pass(i);
  EXPECT_TRUE(trace.exact());
  EXPECT_EQ(InputTrace::pass(42), 42u);
  EXPECT_FALSE(trace.exact());
  trace.write();
  EXPECT_TRUE(trace.exact());
}

// Two loops that pass values both ways at their own pace: each read of the second run gives what it gave in the first.
struct Exchange {
  struct Loop {
    std::vector<std::vector<std::uint64_t>> learned;
    std::vector<std::uint32_t> got;  // wraps round
  };
  TripleBuffer<std::uint32_t> there, back;
  Loop first, second;

  static void turn(TripleBuffer<std::uint32_t>& from, TripleBuffer<std::uint32_t>& to, Loop& loop,
                   std::uint32_t i) {
    std::uint32_t value = 7;
    from.read(value);
    loop.got.push_back(value);
    to.write(3 * value + i);
  }
};

TEST(InputTrace, TwoThreadsMeetAgainAsTheyHadMet) {
  constexpr std::uint32_t kTurns = 20000;
  Exchange then;
  const auto write = [](TripleBuffer<std::uint32_t>& from, TripleBuffer<std::uint32_t>& to,
                        Exchange::Loop& loop) {
    for (std::uint32_t i = 0; i < kTurns; ++i) {
      InputTrace trace;
      trace.write();
      const InputTrace::Scope scope(&trace);
      Exchange::turn(from, to, loop, i);
      loop.learned.emplace_back(trace.values().begin(), trace.values().end());
    }
  };
  {
    std::jthread other([&] { write(then.there, then.back, then.second); });
    write(then.back, then.there, then.first);
  }
  Exchange now;
  InputPlayback playback(2);
  const auto play = [&](TripleBuffer<std::uint32_t>& from, TripleBuffer<std::uint32_t>& to,
                        Exchange::Loop& loop, const Exchange::Loop& before) {
    for (std::uint32_t i = 0; i < kTurns; ++i) {
      InputTrace trace;
      trace.play(before.learned[i], playback);
      const InputTrace::Scope scope(&trace);
      Exchange::turn(from, to, loop, i);
    }
    playback.end_loop();
  };
  {
    std::jthread other([&] { play(now.there, now.back, now.second, then.second); });
    play(now.back, now.there, now.first, then.first);
  }
  EXPECT_FALSE(playback.failed());
  EXPECT_EQ(now.first.got, then.first.got);
  EXPECT_EQ(now.second.got, then.second.got);
}

TEST(InputPlayback, WhatNeverComesIsNotAwaitedForEver) {
  TripleBuffer<int> box;
  InputPlayback playback(2);
  std::jthread ends([&] { playback.end_loop(); });
  InputTrace trace;
  const std::vector<std::uint64_t> learned{5};
  trace.play(learned, playback);
  const InputTrace::Scope scope(&trace);
  int value = 0;
  EXPECT_FALSE(box.read(value));
  EXPECT_TRUE(playback.failed());
}

TEST(InputPlayback, WhereAllWaitItHasFailed) {
  TripleBuffer<int> there, back;
  InputPlayback playback(2);
  const std::vector<std::uint64_t> learned{1};
  const auto await = [&](TripleBuffer<int>& from) {
    InputTrace trace;
    trace.play(learned, playback);
    const InputTrace::Scope scope(&trace);
    int value = 0;
    EXPECT_FALSE(from.read(value));
  };
  std::jthread other([&] { await(there); });
  await(back);
  other.join();
  EXPECT_TRUE(playback.failed());
}

}  // namespace
}  // namespace palpate::inline time
