#include "palpate/network/state_watch.h"

#include <gtest/gtest.h>
#include <zmq.h>

#include <set>

#include "palpate/network/zmq_publisher.h"
#include "palpate/network/zmq_rig_test.h"

namespace palpate {
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

TEST(StateWatch, AnObserverThatDoesNotTakeItsMailMissesSomeAndHoldsUpNobody) {
  ZmqRig rig;
  auto server = rig.serve();
  auto stalled = watch_states(rig.endpoint, 1000), lively = watch_states(rig.endpoint, 1000);
  ASSERT_EQ(taken_from(rig, **stalled, 1).size(), 1u);
  // Far more than the queues of both sides hold.
  ASSERT_GE(taken_from(rig, **lively, 400).size(), 400u);
  std::uint64_t last = 0;
  rig.until({}, [&] {
    if (const auto state = (*stalled)->take()) last = state->number;
    return (*stalled)->counters().missed > 0;
  });
  EXPECT_GT((*stalled)->counters().missed, 0u);
  EXPECT_LT((*stalled)->counters().missed, last);
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

TEST(StateWatch, TopicsThatNameNoRateAreNotServed) {
  ZmqRig rig;
  auto server = rig.serve();
  auto stranger = zmq::Socket::make(ZMQ_SUB);
  for (const std::string topic :
       {"", "state@", "state@0;", "state@2000;", "state@030;", "state@x;", "other@30;"})
    zmq_setsockopt(stranger->get(), ZMQ_SUBSCRIBE, topic.data(), topic.size());
  ASSERT_EQ(zmq_connect(stranger->get(), (rig.endpoint.address + ".states").c_str()), 0);
  auto watch = watch_states(rig.endpoint, 100);
  ASSERT_EQ(taken_from(rig, **watch, 5).size(), 5u);
  // The empty topic is a prefix of all: it gets what others asked for, and nothing else.
  std::string body, topic;
  while (stranger->receive(2, &topic, body) == zmq::Socket::Received::message) EXPECT_EQ(topic, "state@100;");
  EXPECT_FALSE(watch_states(rig.endpoint, 0));
  EXPECT_FALSE(watch_states(rig.endpoint, 1001));
}

TEST(StateWatch, AFloodOfRatesIsBounded) {
  ZmqRig rig;
  auto server = rig.serve();
  auto stranger = zmq::Socket::make(ZMQ_SUB);
  for (int rate = 1; rate <= 1000; ++rate) {
    const std::string topic = zmq::topic_of(rate);
    zmq_setsockopt(stranger->get(), ZMQ_SUBSCRIBE, topic.data(), topic.size());
  }
  ASSERT_EQ(zmq_connect(stranger->get(), (rig.endpoint.address + ".states").c_str()), 0);
  std::set<std::string> topics;
  std::string body, topic;
  for (int i = 0; i < 300; ++i) {
    while (stranger->receive(2, &topic, body) == zmq::Socket::Received::message) topics.insert(topic);
    rig.wait_a_little();
  }
  EXPECT_GT(topics.size(), 0u);
  EXPECT_LE(topics.size(), zmq::kMaxRatesAtOnce);
}

}  // namespace
}  // namespace palpate
