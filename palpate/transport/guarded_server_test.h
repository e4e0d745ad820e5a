// For tests: a physics server at an encrypted TCP address of this machine, with keys in a folder of its own.
#pragma once

#include <gtest/gtest.h>

#include "palpate/transport/state_watch.h"
#include "palpate/transport/zmq_rig_test.h"

namespace palpate::transport::testing {

// And clients of every kind.
class GuardedServer : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(write_key_pair(scratch.path(), own, false));
    ASSERT_TRUE(authorize_key(scratch.path(), {Role::observer, observer.public_key, "observer"}));
    ASSERT_TRUE(authorize_key(scratch.path(), {Role::graphics, graphics.public_key, "graphics"}));
    ASSERT_TRUE(authorize_key(scratch.path(), {Role::operator_, chief.public_key, "operator"}));
    const auto listen = parse_endpoint("tcp://127.0.0.1:0", EndpointUse::listen);
    ASSERT_TRUE(listen && listen->encrypted);
    scene::SceneDescription scene = table_scene();
    scene.shape_vertices = scene::Shape::kMaxVertices;
    auto made = serve_states(*listen, rig.physics_clock, state_at, scene,
                             {.identity = *server_identity(scratch.path()), .status = {}, .shape = shape_at});
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

  std::unique_ptr<StateWatch> watch(const KeyPair& keys, int rate_hz = 100) {
    auto made = watch_states(endpoint, rate_hz, ClientIdentity{keys, own.public_key});
    EXPECT_TRUE(made) << made.error().message;
    return std::move(*made);
  }

  // Asks for a state and a serve for a while.
  void expect_nothing_for(StateLink& link, int milliseconds = 600) {
    std::uint64_t number = 0;
    link.send_control(scene::Control::begin);
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

}  // namespace palpate::transport::testing
