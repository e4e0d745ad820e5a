// Who gets in over TCP and who does not: each stranger tries a state and a control call.
#include <gtest/gtest.h>
#include <zmq.h>

#include <set>

#include "palpate/network/messages.h"
#include "palpate/network/state_watch.h"
#include "palpate/network/zmq_publisher.h"
#include "palpate/network/zmq_rig_test.h"
#include "palpate/network/zmq_socket.h"

namespace palpate {
namespace {

using testing::state_at;
using testing::table_scene;
using testing::ZmqRig;

// A server at an encrypted TCP address with keys in a folder of its own, and clients of every kind.
class GuardedServer : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(write_key_pair(scratch.path(), own, false));
    ASSERT_TRUE(authorize_key(scratch.path(), {Role::observer, observer.public_key, "observer"}));
    ASSERT_TRUE(authorize_key(scratch.path(), {Role::graphics, graphics.public_key, "graphics"}));
    ASSERT_TRUE(authorize_key(scratch.path(), {Role::operator_, chief.public_key, "operator"}));
    const auto listen = parse_endpoint("tcp://127.0.0.1:0", EndpointUse::listen);
    ASSERT_TRUE(listen && listen->encrypted);
    SceneDescription scene = table_scene();
    scene.shape_vertices = Shape::kMaxVertices;
    auto made = serve_states(
        *listen, rig.physics_clock, state_at, scene,
        {.identity = *server_identity(scratch.path()), .status = {}, .shape = testing::shape_at});
    ASSERT_TRUE(made) << made.error().message;
    server = std::move(*made);
    endpoint = *parse_endpoint(server->endpoint(), EndpointUse::connect);
  }

  std::unique_ptr<StateLink> connect(const KeyPair& keys, const std::string& server_key) {
    auto link = connect_states(endpoint, rig.graphics_clock, "test", ClientIdentity{keys, server_key});
    EXPECT_TRUE(link) << link.error().message;
    return std::move(*link);
  }
  std::unique_ptr<StateLink> connect(const KeyPair& keys) { return connect(keys, own.public_key); }

  // Asks for a state and a serve for a while.
  void expect_nothing_for(StateLink& link, int milliseconds = 600) {
    std::uint64_t number = 0;
    link.send_control(Control::serve);
    for (int i = 0; i < milliseconds; ++i) {
      link.poll();
      if (i % 20 == 0) link.request(++number, {seconds(1)});
      rig.wait_a_little();
    }
    EXPECT_FALSE(link.newest());
    EXPECT_FALSE(link.description());
    EXPECT_FALSE(server->take_control());
  }
  bool gets_a_state(StateLink& link, std::uint64_t number) {
    return rig.until({&link}, [&] { return link.request(number, {seconds(1)}); }) &&
           rig.until({&link}, [&] { return link.newest() && link.newest()->reply.number == number; });
  }

  const KeyPair own = *make_key_pair(), observer = *make_key_pair(), graphics = *make_key_pair(),
                chief = *make_key_pair();
  ScratchFolder scratch;
  ZmqRig rig;
  Endpoint endpoint;
  std::unique_ptr<StateService> server;
};

TEST_F(GuardedServer, AnswersWhoIsAdmittedWithTheRoleOfTheKey) {
  for (const auto& [keys, role] :
       {std::pair(observer, Role::observer), {graphics, Role::graphics}, {chief, Role::operator_}}) {
    auto link = connect(keys);
    ASSERT_TRUE(gets_a_state(*link, 1));
    ASSERT_TRUE(rig.until({link.get()}, [&] { return link->role().has_value(); }));
    EXPECT_EQ(link->role(), role);
    EXPECT_TRUE(link->description());
    EXPECT_FALSE(link->trouble());
  }
}

TEST_F(GuardedServer, TheLargestShapeComesThroughSealed) {
  auto link = connect(graphics);
  ASSERT_TRUE(rig.until({link.get()}, [&] { return link->description().has_value(); }));
  for (std::uint64_t number = 1; number <= 3; ++number) {
    const Instant<PhysicsClock> time{seconds(static_cast<double>(number))};
    ASSERT_TRUE(rig.until({link.get()}, [&] { return link->request(number, time, true); }));
    ASSERT_TRUE(
        rig.until({link.get()}, [&] { return link->newest_shape() && link->newest_shape()->time == time; }));
    EXPECT_EQ(link->newest_shape()->vertices(), Shape::kMaxVertices);
  }
  EXPECT_EQ(link->counters().lost, 0u);
}

TEST_F(GuardedServer, ControlCallsNeedTheirRole) {
  struct Case {
    KeyPair keys;
    Control control;
    bool allowed;
  };
  for (const auto& c : {Case{observer, Control::serve, false}, Case{observer, Control::pause, false},
                        Case{graphics, Control::serve, true}, Case{graphics, Control::reset, false},
                        Case{chief, Control::reset, true}}) {
    auto link = connect(c.keys);
    ASSERT_TRUE(rig.until({link.get()}, [&] { return link->role().has_value(); }));
    link->send_control(c.control);
    std::optional<Control> done;
    ASSERT_TRUE(rig.until({link.get()}, [&] {
      done = server->take_control();
      return done || link->refusal();
    }));
    EXPECT_EQ(done.has_value(), c.allowed) << static_cast<int>(c.control);
    if (!c.allowed) {
      EXPECT_NE(link->refusal()->find("may not do that"), std::string::npos) << *link->refusal();
      EXPECT_EQ(link->controls_dropped(), 1u);
      EXPECT_FALSE(server->take_control());
    }
  }
}

TEST_F(GuardedServer, AClientWithoutKeysGetsNothing) {
  const auto open = *parse_endpoint(endpoint.address, EndpointUse::connect, true);
  auto link = std::move(*connect_states(open, rig.graphics_clock));
  expect_nothing_for(*link);
  EXPECT_EQ(server->counters().requests, 0u);
}

TEST_F(GuardedServer, AnUnknownKeyGetsNothingAndIsToldWhy) {
  auto link = connect(*make_key_pair());
  expect_nothing_for(*link);
  ASSERT_TRUE(link->trouble());
  EXPECT_NE(link->trouble()->find("palpate keys authorize"), std::string::npos) << *link->trouble();
  EXPECT_GT(server->counters().turned_away, 0u);
}

TEST_F(GuardedServer, AClientThatExpectsAnotherServerGetsNothingAndIsToldWhy) {
  auto link = connect(graphics, make_key_pair()->public_key);
  expect_nothing_for(*link);
  ASSERT_TRUE(link->trouble());
  EXPECT_NE(link->trouble()->find("another key"), std::string::npos) << *link->trouble();
}

TEST_F(GuardedServer, ARevokedKeyLosesItsRightsWhileItIsConnectedAndOthersKeepTheirs) {
  auto leaving = connect(graphics), staying = connect(chief);
  ASSERT_TRUE(gets_a_state(*leaving, 1));
  ASSERT_TRUE(gets_a_state(*staying, 1));
  ASSERT_TRUE(revoke_keys(scratch.path(), "graphics"));
  ASSERT_TRUE(rig.until({leaving.get(), staying.get()}, [&] { return leaving->refusal().has_value(); }));
  const auto replies = leaving->counters().replies;
  leaving->send_control(Control::serve);
  for (std::uint64_t n = 2; n < 20; ++n) {
    leaving->request(n, {seconds(2)});
    rig.wait_a_little();
    leaving->poll();
  }
  EXPECT_EQ(leaving->counters().replies, replies);
  EXPECT_FALSE(server->take_control());
  EXPECT_TRUE(gets_a_state(*staying, 2));
  auto back = connect(graphics);
  expect_nothing_for(*back);
  // And in again, without a restart.
  ASSERT_TRUE(authorize_key(scratch.path(), {Role::graphics, graphics.public_key, ""}));
  EXPECT_TRUE(gets_a_state(*back, 1000));
}

TEST_F(GuardedServer, ObserversOfStatesComeThroughTheSameGateAndLoseTheirRightsToo) {
  const auto watch = [&](const KeyPair& keys) {
    return std::move(*watch_states(endpoint, 100, ClientIdentity{keys, own.public_key}));
  };
  auto leaving = watch(observer), staying = watch(graphics), stranger = watch(*make_key_pair());
  ASSERT_TRUE(rig.until({}, [&] { return leaving->take().has_value(); }));
  ASSERT_TRUE(rig.until({}, [&] { return staying->take().has_value(); }));
  EXPECT_FALSE(stranger->take());
  const auto open = *parse_endpoint(endpoint.address, EndpointUse::connect, true);
  auto bare = std::move(*watch_states(open, 100));
  ASSERT_TRUE(revoke_keys(scratch.path(), "observer"));
  // Half a second until the list is looked at; then the others come in again, and this one does not.
  Instant<PhysicsClock> last = rig.physics_clock.now();
  ASSERT_TRUE(rig.until({}, [&] {
    if (const auto state = leaving->take()) last = state->asked;
    return rig.physics_clock.now() - last > std::chrono::milliseconds(1500);
  }));
  EXPECT_TRUE(rig.until({}, [&] {
    const auto state = staying->take();
    return state && state->asked > last;
  }));
  EXPECT_FALSE(leaving->take());
  EXPECT_FALSE(stranger->take());
  EXPECT_FALSE(bare->take());
}

TEST_F(GuardedServer, AKeyHasFourRatesAndWhatItLeavesGoesToTheOthers) {
  auto greedy = zmq::Socket::make(ZMQ_SUB);
  ASSERT_TRUE(greedy && zmq::encrypt(*greedy, {observer, own.public_key}));
  for (int rate = 1; rate <= 30; ++rate) {
    const std::string topic = zmq::topic_of(rate);
    zmq_setsockopt(greedy->get(), ZMQ_SUBSCRIBE, topic.data(), topic.size());
  }
  ASSERT_EQ(zmq_connect(greedy->get(), server->states_endpoint().c_str()), 0);
  std::string body, topic;
  ASSERT_TRUE(
      rig.until({}, [&] { return greedy->receive(2, &topic, body) == zmq::Socket::Received::message; }));
  auto modest = std::move(*watch_states(endpoint, 100, ClientIdentity{graphics, own.public_key}));
  EXPECT_TRUE(rig.until({}, [&] { return modest->take().has_value(); }));
  std::set<std::string> topics;
  rig.until({}, [&] {
    while (greedy->receive(2, &topic, body) == zmq::Socket::Received::message)
      if (topic != "state@100;") topics.insert(topic);
    return topics.size() > zmq::kMaxRatesEach;
  });
  EXPECT_EQ(topics.size(), zmq::kMaxRatesEach);
}

// ZeroMQ keeps every topic that anybody asks for, in memory that a server of ours locks.
TEST_F(GuardedServer, WhoAsksForTopicsWithoutEndIsShutOutAndTheOthersComeBack) {
  auto staying = std::move(*watch_states(endpoint, 100, ClientIdentity{graphics, own.public_key}));
  ASSERT_TRUE(rig.until({}, [&] { return staying->take().has_value(); }));
  auto greedy = zmq::Socket::make(ZMQ_SUB);
  ASSERT_TRUE(greedy && zmq::encrypt(*greedy, {observer, own.public_key}));
  const std::string wanted = "state@50;";
  zmq_setsockopt(greedy->get(), ZMQ_SUBSCRIBE, wanted.data(), wanted.size());
  ASSERT_EQ(zmq_connect(greedy->get(), server->states_endpoint().c_str()), 0);
  std::string body, topic;
  ASSERT_TRUE(
      rig.until({}, [&] { return greedy->receive(2, &topic, body) == zmq::Socket::Received::message; }));
  for (int i = 0; i < 300; ++i) {
    const std::string nonsense = std::to_string(i) + std::string(2000, 'x');
    zmq_setsockopt(greedy->get(), ZMQ_SUBSCRIBE, nonsense.data(), nonsense.size());
    rig.wait_a_little();
    static_cast<void>(greedy->readable());  // makes room in its own queue
  }
  ASSERT_TRUE(rig.until({}, [&] { return server->counters().rejected > 0; }));
  const auto flooded = rig.physics_clock.now();
  EXPECT_TRUE(rig.until({}, [&] {
    const auto state = staying->take();
    return state && state->asked > flooded + std::chrono::milliseconds(500);
  }));
  bool served = false;
  while (greedy->receive(2, &topic, body) == zmq::Socket::Received::message)
    served = decode_server_message(body) && std::get<StateReply>(*decode_server_message(body)).asked >
                                                flooded + std::chrono::milliseconds(500);
  EXPECT_FALSE(served);
}

TEST_F(GuardedServer, AListThatOthersCanWriteToAdmitsNobodyAnyMore) {
  auto link = connect(chief);
  ASSERT_TRUE(gets_a_state(*link, 1));
  std::filesystem::permissions(scratch / "authorized_keys", std::filesystem::perms::others_write,
                               std::filesystem::perm_options::add);
  ASSERT_TRUE(authorize_key(scratch / "elsewhere", {Role::graphics, graphics.public_key, ""}));
  // Touched, so that the server looks.
  std::filesystem::last_write_time(scratch / "authorized_keys",
                                   std::filesystem::file_time_type::clock::now());
  EXPECT_TRUE(rig.until({link.get()}, [&] { return link->refusal().has_value(); }));
}

TEST_F(GuardedServer, AStrangerWhoForgesTheHandshakeLeavesOthersInPeace) {
  // Bytes that are no ZeroMQ greeting at all, and a greeting that ends in the middle.
  for (const std::string& bytes :
       {std::string(2000, '\xff'), std::string("\xff\0\0\0\0\0\0\0\1\x7f\3", 11)}) {
    auto raw = zmq::Socket::make(ZMQ_STREAM);
    ASSERT_TRUE(raw);
    ASSERT_EQ(zmq_connect(raw->get(), endpoint.address.c_str()), 0);
    char id[256];
    const int size = zmq_recv(raw->get(), id, sizeof id, 0);
    ASSERT_GT(size, 0);
    EXPECT_GE(zmq_send(raw->get(), id, static_cast<std::size_t>(size), ZMQ_SNDMORE), 0);
    EXPECT_GE(zmq_send(raw->get(), bytes.data(), bytes.size(), 0), 0);
    auto link = connect(observer);
    EXPECT_TRUE(gets_a_state(*link, 1));
  }
}

TEST(GuardedServerSetUp, AnEncryptedAddressWithoutKeysIsWrongUse) {
  ZmqRig rig;
  const auto listen = *parse_endpoint("tcp://127.0.0.1:0", EndpointUse::listen);
  EXPECT_EQ(serve_states(listen, rig.physics_clock, state_at, table_scene()).error().exit_code(), 2);
  EXPECT_EQ(connect_states(*parse_endpoint("tcp://127.0.0.1:9", EndpointUse::connect), rig.graphics_clock)
                .error()
                .exit_code(),
            2);
}

}  // namespace
}  // namespace palpate
