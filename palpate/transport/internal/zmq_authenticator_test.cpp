// Who gets in over TCP and who does not: each stranger tries a state and a control call.
#include <gtest/gtest.h>
#include <zmq.h>

#include "palpate/transport/guarded_server_test.h"
#include "palpate/transport/messages.h"
#include "palpate/transport/zmq_socket.h"

namespace palpate::transport {
namespace {

using testing::GuardedServer;
using testing::state_at;
using testing::table_scene;
using testing::ZmqRig;

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
    EXPECT_EQ(link->newest_shape()->vertices(), scene::Shape::kMaxVertices);
  }
  EXPECT_EQ(link->counters().lost, 0u);
}

TEST_F(GuardedServer, ControlCallsNeedTheirRole) {
  struct Case {
    KeyPair keys;
    scene::Control control;
    bool allowed;
  };
  for (const auto& c :
       {Case{observer, scene::Control::begin, false}, Case{observer, scene::Control::pause, false},
        Case{graphics, scene::Control::begin, true}, Case{graphics, scene::Control::reset, false},
        Case{chief, scene::Control::reset, true}}) {
    auto link = connect(c.keys);
    ASSERT_TRUE(rig.until({link.get()}, [&] { return link->role().has_value(); }));
    link->send_control(c.control);
    std::optional<scene::Control> done;
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
  EXPECT_GT(server->counters().rejected_connections, 0u);
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
  leaving->send_control(scene::Control::begin);
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

TEST_F(GuardedServer, AFolderThatOthersCanWriteToAdmitsNobodyUntilItIsTheOwnersAlone) {
  auto link = connect(chief);
  ASSERT_TRUE(gets_a_state(*link, 1));
  std::filesystem::permissions(scratch.path(), std::filesystem::perms(0777));
  EXPECT_TRUE(rig.until({link.get()}, [&] { return link->refusal().has_value(); }));
  std::filesystem::permissions(scratch.path(), std::filesystem::perms(0700));
  auto back = connect(chief);
  EXPECT_TRUE(gets_a_state(*back, 2));
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
}  // namespace palpate::transport
