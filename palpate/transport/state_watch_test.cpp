#include "palpate/transport/state_watch.h"

#include <gtest/gtest.h>

#include "palpate/transport/internal/zmq_publisher.h"
#include "palpate/transport/zmq_rig_test.h"

namespace palpate::transport {
namespace {

using testing::state_at;
using testing::table_scene;
using testing::ZmqRig;

// Takes states until there are `count`.
std::vector<StateReply> taken_from(ZmqRig& rig, StateWatch& watch, std::size_t count) {
  std::vector<StateReply> states;
  rig.until({}, [&] {
    if (const auto state = watch.take()) states.push_back(*state);
    return states.size() >= count;
  });
  return states;
}

TEST(StateWatch, StatesComeByThemselvesAtTheChosenRateAndInOrder) {
  ZmqRig rig;
  auto server = rig.serve();
  ASSERT_TRUE(server);
  EXPECT_EQ((*server)->states_endpoint(), rig.endpoint.address + ".states");
  auto slow = watch_states(rig.endpoint, 50), fast = watch_states(rig.endpoint, 200);
  ASSERT_TRUE(slow && fast);
  std::vector<StateReply> states;
  rig.until({}, [&] {
    (*fast)->take();
    if (const auto state = (*slow)->take()) states.push_back(*state);
    return states.size() >= 20;
  });
  ASSERT_EQ(states.size(), 20u);
  for (std::size_t i = 1; i < states.size(); ++i) {
    EXPECT_GT(states[i].number, states[i - 1].number);
    // Of the moment asked for, which lies a moment before the sending and never runs backwards.
    EXPECT_EQ(states[i].answer.state.time, states[i].asked);
    EXPECT_GT(states[i].asked, states[i - 1].asked);
    EXPECT_LT(states[i].asked, rig.physics_clock.now() - zmq::kObserverDelay);
  }
  const auto fast_count = (*fast)->counters(), slow_count = (*slow)->counters();
  EXPECT_GT(fast_count.taken + fast_count.missed,
            2 * slow_count.taken);  // 4 times, on a machine without other work
  EXPECT_EQ(fast_count.rejected + slow_count.rejected, 0u);
}

TEST(StateWatch, AnObserverThatDoesNotTakeItsMailGetsTheNewestAndHoldsUpNobody) {
  ZmqRig rig;
  auto server = rig.serve();
  auto stalled = watch_states(rig.endpoint, 1000), lively = watch_states(rig.endpoint, 1000);
  ASSERT_EQ(taken_from(rig, **stalled, 1).size(), 1u);
  ASSERT_GE(taken_from(rig, **lively, 400).size(), 400u);
  const auto before = rig.physics_clock.now() - std::chrono::milliseconds(200);
  const auto state = taken_from(rig, **stalled, 1);
  ASSERT_EQ(state.size(), 1u);
  EXPECT_GT(state[0].asked, before);
  EXPECT_GT((*stalled)->counters().skipped, 100u);
}

TEST(StateWatch, ComesBackByItselfWhenTheServerDoes) {
  ZmqRig rig;
  auto server = rig.serve();
  auto watch = watch_states(rig.endpoint, 100);
  ASSERT_EQ(taken_from(rig, **watch, 1).size(), 1u);
  server->reset();
  server = rig.serve();
  ASSERT_TRUE(server) << server.error().message;
  const auto now = rig.physics_clock.now();
  EXPECT_TRUE(rig.until({}, [&] {
    const auto state = (*watch)->take();
    return state && state->asked > now;
  }));
}

TEST(StateWatch, RatesOutOfRangeAreWrongUse) {
  ZmqRig rig;
  for (const int rate_hz : {-1, 0, 1001})
    EXPECT_EQ(watch_states(rig.endpoint, rate_hz).error().exit_code(), 2);
}

}  // namespace
}  // namespace palpate::transport
