// What a graphics server may rely on, whatever carries the messages: the same tests over every engine.
#include <gtest/gtest.h>

#include "palpate/transport/exchange_rig_test.h"
#include "palpate/transport/zmq_rig_test.h"

namespace palpate::transport {
namespace {

using testing::ExchangeRig;
using testing::state_at;
using testing::table_scene;

using MakeRig = std::function<std::unique_ptr<ExchangeRig>()>;
struct Engine {
  const char* name;
  MakeRig make;
};

class Exchange : public ::testing::TestWithParam<Engine> {
 protected:
  std::unique_ptr<ExchangeRig> rig = GetParam().make();
};

TEST_P(Exchange, ARequestIsAnsweredWithTheStateAtItsTime) {
  auto server = rig->serve();
  ASSERT_TRUE(server) << server.error().message;
  auto link = rig->connect();
  const auto time = Instant<PhysicsClock>::from_seconds(12.345678901);
  ASSERT_TRUE(rig->until({link.get()}, [&] { return link->request(1, time); }));
  ASSERT_TRUE(rig->until({link.get()}, [&] { return link->newest().has_value(); }));
  EXPECT_EQ(link->newest()->reply.number, 1u);
  EXPECT_EQ(link->newest()->reply.asked, time);
  EXPECT_EQ(link->newest()->reply.answer.kind, AnswerKind::interpolated);
  EXPECT_EQ(link->newest()->reply.answer.state.bodies[0].position, state_at(time).state.bodies[0].position);
  EXPECT_EQ(link->newest()->reply.answer.state.counters, state_at(time).state.counters);
  EXPECT_GE(link->newest()->received, link->newest()->sent);
  EXPECT_EQ(link->counters().replies, 1u);
  EXPECT_EQ(link->counters().answers[static_cast<std::size_t>(AnswerKind::interpolated)], 1u);
}

TEST_P(Exchange, AShapeComesWithTheStateWhereItIsAskedFor) {
  auto server = rig->serve(testing::cloth_scene());
  auto link = rig->connect();
  ASSERT_TRUE(rig->until({link.get()}, [&] { return link->description().has_value(); }));
  EXPECT_EQ(link->description()->shape_vertices, 10'000u);
  ASSERT_TRUE(link->request(1, {seconds(3)}));
  ASSERT_TRUE(rig->until({link.get()}, [&] { return link->newest().has_value(); }));
  EXPECT_FALSE(link->newest_shape());  // nobody asked
  ASSERT_TRUE(link->request(2, {seconds(4)}, true));
  ASSERT_TRUE(rig->until({link.get()}, [&] { return link->newest_shape() != nullptr; }));
  EXPECT_EQ(link->newest()->reply.number, 2u);
  EXPECT_EQ(link->newest_shape()->time, Instant<PhysicsClock>{seconds(4)});
  std::vector<float> expected(60'000);
  testing::shape_at({seconds(4)}, expected);
  EXPECT_EQ(link->newest_shape()->values, expected);
}

TEST_P(Exchange, LookingBackDoesNotTouchTheFramesOwnRequests) {
  auto server = rig->serve(testing::cloth_scene());
  auto link = rig->connect();
  ASSERT_TRUE(rig->until({link.get()}, [&] { return link->description().has_value(); }));
  ASSERT_TRUE(link->request(7, {seconds(4)}));
  ASSERT_TRUE(rig->until({link.get()}, [&] { return link->newest().has_value(); }));
  const auto counters = link->counters();
  ASSERT_TRUE(link->look_back(3, {seconds(2)}, true));
  ASSERT_TRUE(rig->until({link.get()}, [&] { return !link->looked_back().empty(); }));
  const StateReply& answer = link->looked_back().front();
  EXPECT_EQ(answer.number, 3u);
  EXPECT_EQ(answer.answer.state.time, Instant<PhysicsClock>{seconds(2)});
  ASSERT_TRUE(answer.shape);
  EXPECT_EQ(answer.shape->time, Instant<PhysicsClock>{seconds(2)});
  EXPECT_EQ(link->newest()->reply.number, 7u);
  EXPECT_FALSE(link->newest_shape());
  EXPECT_EQ(link->counters(), counters);
  link->poll();
  EXPECT_TRUE(link->looked_back().empty()) << "only what the last poll brought";
}

TEST_P(Exchange, WithoutASurfaceThatDeformsAShapeIsAskedForInVain) {
  auto server = rig->serve();
  auto link = rig->connect();
  ASSERT_TRUE(rig->until({link.get()}, [&] { return link->request(1, {seconds(4)}, true); }));
  ASSERT_TRUE(rig->until({link.get()}, [&] { return link->newest().has_value(); }));
  EXPECT_FALSE(link->newest_shape());
}

TEST_P(Exchange, WhoAsksHowTheServerIsDoingHearsOfEveryClient) {
  auto server = rig->serve();
  auto busy = rig->connect("screen"), asking = rig->connect("status");
  busy->tell({.frames = 60, .late = 1, .rate_hz = 30.0, .round_trip_median_us = 200.0});
  ASSERT_TRUE(rig->until({busy.get()}, [&] { return busy->peer_alive(); }));
  ASSERT_TRUE(rig->until({busy.get(), asking.get()}, [&] {
    asking->ask_status();
    return asking->status() && asking->status()->clients.size() == 2;
  }));
  const auto& clients = asking->status()->clients;
  EXPECT_EQ(asking->status()->application, "marbles");
  const auto screen =
      std::find_if(clients.begin(), clients.end(), [](const auto& c) { return c.name == "screen"; });
  ASSERT_NE(screen, clients.end());
  EXPECT_EQ(screen->figures.frames, 60u);
  EXPECT_EQ(screen->figures.round_trip_median_us, 200.0);
  busy.reset();
  EXPECT_TRUE(rig->until({asking.get()}, [&] {
    asking->ask_status();
    return asking->status()->clients.size() == 1;
  }));
}

TEST_P(Exchange, AReplyThatIsNotThereYetLeavesThePreviousStateInUse) {
  auto server = rig->serve();
  auto link = rig->connect();
  ASSERT_TRUE(rig->until({link.get()}, [&] { return link->request(1, {seconds(1)}); }));
  ASSERT_TRUE(rig->until({link.get()}, [&] { return link->newest().has_value(); }));
  link->frame_drawn(1);
  ASSERT_TRUE(link->request(2, {seconds(2)}));
  link->frame_drawn(2);  // at once: nothing has been polled since the request
  EXPECT_EQ(link->newest()->reply.number, 1u);
  ASSERT_TRUE(rig->until({link.get()}, [&] { return link->newest()->reply.number == 2; }));
  EXPECT_EQ(link->counters().late, 1u);
  EXPECT_EQ(link->counters().frames, 2u);
  EXPECT_EQ(link->counters().frames_in_time, 1u);
  EXPECT_EQ(link->counters().lost, 0u);
}

TEST_P(Exchange, WithoutAServerNothingHangsAndTheLinkSaysSo) {
  auto link = rig->connect();
  EXPECT_FALSE(link->request(1, {seconds(1)}));
  for (int i = 0; i < 50; ++i) {
    link->poll();
    rig->wait_a_little();
  }
  EXPECT_FALSE(link->peer_alive());
  EXPECT_FALSE(link->since_last_word().has_value());
  EXPECT_FALSE(link->send_sync());
  EXPECT_EQ(link->counters().unsent, 1u);
  EXPECT_EQ(link->counters().sent, 0u);
}

TEST_P(Exchange, AClientThatWasThereFirstFindsTheServer) {
  auto link = rig->connect();
  for (int i = 0; i < 20; ++i) {
    link->poll();
    rig->wait_a_little();
  }
  auto server = rig->serve();
  EXPECT_TRUE(
      rig->until({link.get()}, [&] { return link->peer_alive() && link->description().has_value(); }));
}

TEST_P(Exchange, WhoeverJoinsLateLearnsTheScene) {
  auto server = rig->serve(table_scene("a game"));
  auto first = rig->connect("first");
  ASSERT_TRUE(rig->until({first.get()}, [&] { return first->description().has_value(); }));
  auto second = rig->connect("second");
  ASSERT_TRUE(rig->until({first.get(), second.get()}, [&] { return second->description().has_value(); }));
  EXPECT_EQ(second->description()->application, "a game");
  ASSERT_EQ(second->description()->surfaces.size(), 1u);
  EXPECT_EQ(second->description()->surfaces[0].corners, table_scene().surfaces[0].corners);
  EXPECT_EQ(first->session(), second->session());
  ASSERT_TRUE(rig->until({first.get(), second.get()}, [&] { return (*server)->counters().clients == 2; }));
  second.reset();
  EXPECT_TRUE(rig->until({first.get()}, [&] { return (*server)->counters().clients == 1; }));
}

TEST_P(Exchange, ADeadServerIsNoticedAndItsSuccessorFound) {
  auto server = rig->serve(table_scene("before"));
  auto link = rig->connect();
  ASSERT_TRUE(
      rig->until({link.get()}, [&] { return link->peer_alive() && link->description().has_value(); }));
  const std::uint64_t session = link->session();
  server->reset();
  ASSERT_TRUE(rig->until({link.get()}, [&] { return !link->peer_alive(); }));
  EXPECT_GT(*link->since_last_word(), Duration(0));
  EXPECT_EQ(link->description()->application, "before");
  server = rig->serve(table_scene("after"));
  ASSERT_TRUE(server) << server.error().message;
  ASSERT_TRUE(rig->until({link.get()}, [&] { return link->peer_alive() && link->session() != session; }));
  EXPECT_EQ(link->description()->application, "after");
  ASSERT_TRUE(link->request(1, {seconds(1)}));
  EXPECT_TRUE(rig->until({link.get()}, [&] { return link->newest().has_value(); }));
}

TEST_P(Exchange, ASecondServerAtTheSameAddressIsRefused) {
  auto server = rig->serve();
  ASSERT_TRUE(server);
  auto second = rig->serve();
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().kind, Error::Kind::refused);
  auto link = rig->connect();  // and the first still answers
  EXPECT_TRUE(rig->until({link.get()}, [&] { return link->peer_alive(); }));
}

TEST_P(Exchange, AWishIsCarriedOutOnceAndInOrder) {
  auto server = rig->serve();
  auto link = rig->connect();
  EXPECT_TRUE(link->send_control(scene::Control::begin));
  EXPECT_TRUE(link->send_control(scene::Control::pause));
  EXPECT_TRUE(link->send_control(scene::Control::resume));
  EXPECT_EQ(link->controls_waiting(), 3u);
  std::vector<scene::Control> taken;
  rig->until({link.get()}, [&] {
    while (auto control = (*server)->take_control()) taken.push_back(*control);
    return taken.size() >= 3;
  });
  EXPECT_EQ(taken, (std::vector{scene::Control::begin, scene::Control::pause, scene::Control::resume}));
  for (int i = 0; i < 300; ++i) {  // long enough for a second copy, were one sent
    link->poll();
    rig->wait_a_little();
  }
  EXPECT_FALSE((*server)->take_control().has_value());
  EXPECT_EQ(link->controls_waiting(), 0u);
  EXPECT_EQ(link->controls_dropped(), 0u);
}

TEST_P(Exchange, AClockExchangeBringsFourStampsInOrder) {
  auto server = rig->serve();
  auto link = rig->connect();
  ASSERT_TRUE(rig->until({link.get()}, [&] { return link->send_sync(); }));
  std::optional<SyncStamps> stamps;
  ASSERT_TRUE(rig->until({link.get()}, [&] { return (stamps = link->take_sync()).has_value(); }));
  EXPECT_LE(stamps->t1, stamps->t4);
  EXPECT_LE(stamps->t2, stamps->t3);
  EXPECT_LE(stamps->t3 - stamps->t2,
            stamps->t4 - stamps->t1);  // the server's share lies inside the round trip
}

TEST_P(Exchange, SeveralClientsAreAnsweredEachItsOwn) {
  auto server = rig->serve();
  std::vector<std::unique_ptr<StateLink>> links;
  std::vector<StateLink*> all;
  for (int i = 0; i < 4; ++i) {
    links.push_back(rig->connect());
    all.push_back(links.back().get());
  }
  for (std::uint64_t n = 1; n <= 20; ++n) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      ASSERT_TRUE(
          rig->until(all, [&] { return all[i]->request(n, {seconds(10.0 * static_cast<double>(i + n))}); }));
    }
    ASSERT_TRUE(rig->until(all, [&] {
      return std::all_of(all.begin(), all.end(),
                         [&](StateLink* l) { return l->newest() && l->newest()->reply.number == n; });
    }));
    for (std::size_t i = 0; i < all.size(); ++i) {
      EXPECT_EQ(all[i]->newest()->reply.answer.state.time,
                (Instant<PhysicsClock>{seconds(10.0 * static_cast<double>(i + n))}));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Engines, Exchange,
    ::testing::Values(Engine{"InProcess", [] { return std::make_unique<testing::InProcessRig>(); }},
                      Engine{"ZeroMq", [] { return std::make_unique<testing::ZmqRig>(); }}),
    [](const auto& engine) { return engine.param.name; });

}  // namespace
}  // namespace palpate::transport
