#include "palpate/time/state_history.h"

#include <gtest/gtest.h>

#include <deque>
#include <thread>
#include <vector>

#include "palpate/core/random.h"

namespace palpate::inline time {
namespace {

struct Ball {
  Instant<PhysicsClock> time;
  double position = 0.0, velocity = 0.0;
  std::uint32_t jumps = 0;
  std::array<double, 20> check{};  // a function of the time: shows torn copies
};

Ball ball(std::int64_t ns, double position, double velocity, std::uint32_t jumps = 0) {
  Ball b{{Duration(ns)}, position, velocity, jumps, {}};
  for (std::size_t i = 0; i < b.check.size(); ++i)
    b.check[i] = static_cast<double>(ns) * (1.0 + static_cast<double>(i));
  return b;
}

// Linear; across an impact each side keeps its own course.
Ball between(const Ball& a, const Ball& b, double s) {
  const double dt = to_seconds(b.time - a.time);
  Ball c = a.jumps == b.jumps || s < 0.5 ? a : b;
  c.time = a.time + Duration(std::llround(s * 1e9 * dt));
  if (a.jumps == b.jumps) {
    c.position = (1.0 - s) * a.position + s * b.position;
  } else {
    c.position = s < 0.5 ? a.position + s * dt * a.velocity : b.position - (1.0 - s) * dt * b.velocity;
  }
  return c;
}

Ball ahead(const Ball& a, Duration by) {
  Ball c = a;
  c.time += by;
  c.position += to_seconds(by) * a.velocity;
  return c;
}

template <std::size_t N>
HistoryAnswer<Ball> ask(const StateHistory<Ball, N>& history, std::int64_t ns) {
  return history.at({Duration(ns)}, between, ahead);
}

TEST(StateHistory, AnEmptyOneSaysSo) {
  const StateHistory<Ball, 8> history(seconds(1));
  EXPECT_EQ(ask(history, 0).kind, AnswerKind::too_new);
  EXPECT_FALSE(ask(history, 0).usable());
}

TEST(StateHistory, SaysHowItKnew) {
  StateHistory<Ball, 8> history(Duration(500));
  for (int i = 1; i <= 5; ++i) EXPECT_TRUE(history.push(ball(1000 * i, 10.0 * i, 1e7)));
  EXPECT_EQ(ask(history, 3000).kind, AnswerKind::exact);
  EXPECT_EQ(ask(history, 3000).state.position, 30.0);
  EXPECT_EQ(ask(history, 3250).kind, AnswerKind::interpolated);
  EXPECT_EQ(ask(history, 3250).state.position, 32.5);
  EXPECT_EQ(ask(history, 5000).kind, AnswerKind::exact);
  EXPECT_EQ(ask(history, 5400).kind, AnswerKind::extrapolated);
  EXPECT_EQ(ask(history, 5400).extrapolated_by, Duration(400));
  EXPECT_NEAR(ask(history, 5400).state.position, 54.0, 1e-9);
  EXPECT_EQ(ask(history, 5501).kind, AnswerKind::too_new);
  EXPECT_EQ(ask(history, 5501).extrapolated_by, Duration(501));
  EXPECT_EQ(ask(history, 5501).state.time.ns(), 5000);
  EXPECT_EQ(ask(history, 999).kind, AnswerKind::too_old);
  EXPECT_EQ(ask(history, 999).extrapolated_by, Duration(-1));
  EXPECT_EQ(ask(history, 999).state.time.ns(), 1000);
}

TEST(StateHistory, RefusesATimeThatDoesNotIncrease) {
  StateHistory<Ball, 8> history(Duration(0));
  EXPECT_TRUE(history.push(ball(10, 0, 0)));
  EXPECT_FALSE(history.push(ball(10, 1, 0)));
  EXPECT_FALSE(history.push(ball(9, 1, 0)));
  EXPECT_EQ(history.count(), 1u);
  EXPECT_EQ(ask(history, 10).state.position, 0.0);
}

TEST(StateHistory, AsksTheInterpolationNotToCrossAnImpact) {
  StateHistory<Ball, 8> history(Duration(0));
  history.push(ball(0, 1.0, -1.0, 0));         // falls at 1 m/s,
  history.push(ball(1'000'000, 1.0, 0.9, 1));  // and is thrown back in between
  EXPECT_NEAR(ask(history, 400'000).state.position, 1.0 - 0.4e-3, 1e-12);
  EXPECT_NEAR(ask(history, 600'000).state.position, 1.0 - 0.9 * 0.4e-3, 1e-12);
}

// Against a plain search through everything that was ever stored.
template <std::size_t N>
void compare_with_brute_force(std::uint64_t seed, bool even) {
  Random random(seed, even ? "even" : "uneven");
  StateHistory<Ball, N> history(Duration(1500));
  std::deque<Ball> all;
  std::int64_t t = 5'000;
  for (int i = 0; i < 400; ++i) {
    t += even ? 1000 : 1 + static_cast<std::int64_t>(std::exp(12.0 * random.uniform()));
    const Ball b = ball(t, random.normal(), random.normal());
    history.push(b);
    all.push_back(b);
    if (all.size() > N - 1) all.pop_front();
    const std::int64_t first = all.front().time.ns() - 2000, last = t + 3000;
    for (int q = 0; q < 40; ++q) {
      std::int64_t when =
          first + static_cast<std::int64_t>(random.below(static_cast<std::uint64_t>(last - first)));
      if (q % 4 == 0) when = all[random.below(all.size())].time.ns();
      const auto answer = ask(history, when);
      std::size_t after = 0;
      while (after < all.size() && all[after].time.ns() <= when) ++after;
      if (after == 0) {
        ASSERT_EQ(answer.kind, AnswerKind::too_old);
        ASSERT_EQ(answer.extrapolated_by, Duration(when - all.front().time.ns()));
      } else if (all[after - 1].time.ns() == when) {
        ASSERT_EQ(answer.kind, AnswerKind::exact);
        ASSERT_EQ(answer.state.position, all[after - 1].position);
      } else if (after == all.size()) {
        ASSERT_EQ(answer.kind, when - t > 1500 ? AnswerKind::too_new : AnswerKind::extrapolated);
        ASSERT_EQ(answer.extrapolated_by, Duration(when - t));
      } else {
        const Ball &a = all[after - 1], &c = all[after];
        const double s = to_seconds(Duration(when) - a.time.since_epoch) / to_seconds(c.time - a.time);
        ASSERT_EQ(answer.kind, AnswerKind::interpolated);
        ASSERT_EQ(answer.state.position, between(a, c, s).position);
      }
    }
  }
}

TEST(StateHistory, AgreesWithBruteForceAtAFixedRateThroughManyRounds) {
  compare_with_brute_force<2>(1, true);
  compare_with_brute_force<7>(2, true);
  compare_with_brute_force<64>(3, true);
  compare_with_brute_force<1024>(4, true);
}

TEST(StateHistory, AgreesWithBruteForceWhereStepsDifferByFiveDecades) {
  compare_with_brute_force<7>(5, false);
  compare_with_brute_force<64>(6, false);
  compare_with_brute_force<1024>(7, false);
}

// One writer as fast as it goes, readers beside it; the ring is small so that readers are lapped all the
// time.
template <std::size_t N>
void readers_beside_a_writer(int entries) {
  StateHistory<Ball, N> history(Duration(300));
  std::atomic<bool> done{false};
  std::array<std::uint64_t, 2> wrong{}, torn{};
  std::array<std::atomic<int>, 2> usable{};
  std::vector<std::thread> readers;
  for (std::size_t r = 0; r < 2; ++r)
    readers.emplace_back([&, r] {
      Random random(r, "reader");
      while (!done.load(std::memory_order_acquire)) {
        const std::int64_t now = static_cast<std::int64_t>(history.count()) * 1000;
        const std::int64_t when = now - static_cast<std::int64_t>(random.below(N * 1100));
        const auto answer = history.at({Duration(when)}, between, ahead);
        for (std::size_t i = 0; i < answer.state.check.size(); ++i)
          torn[r] += answer.state.check[i] != answer.state.check[0] * (1.0 + static_cast<double>(i));
        if (!answer.usable()) continue;
        ++usable[r];
        // Everything pushed lies on position = 1e-3 t: so must every answer.
        wrong[r] += std::abs(answer.state.position - 1e-3 * static_cast<double>(when)) > 1e-6;
      }
    });
  // On until both readers have had their turn.
  for (int i = 0; i < entries || usable[0] == 0 || usable[1] == 0; ++i) {
    history.push(ball(1000ll * (i + 1), i + 1.0, 1e6));
    if (i % 64 == 0) std::this_thread::yield();
  }
  done.store(true, std::memory_order_release);
  for (auto& thread : readers) thread.join();
  for (std::size_t r = 0; r < 2; ++r) {
    EXPECT_EQ(torn[r], 0u);
    EXPECT_EQ(wrong[r], 0u);
  }
}

TEST(StateHistory, ReadersBesideAWriterNeverSeeATornOrWrongState) {
  readers_beside_a_writer<4>(15'000);
  readers_beside_a_writer<256>(15'000);
}

}  // namespace
}  // namespace palpate::inline time
