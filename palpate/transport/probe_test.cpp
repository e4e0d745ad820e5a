#include "palpate/transport/probe.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "palpate/transport/zmq_rig_test.h"

namespace palpate::transport {
namespace {

constexpr double kPatienceS = 60.0;  // an answer ends the wait

TEST(Probe, NobodyAnswersWhereNothingListens) {
  testing::ZmqRig rig;
  const auto answered = who_answers(rig.endpoint, {}, kPatienceS);
  ASSERT_TRUE(answered) << answered.error().message;
  EXPECT_EQ(answered->who, Answer::nobody);
}

TEST(Probe, APhysicsServerAnswersWithOurRole) {
  testing::ZmqRig rig;
  const auto server = rig.serve();
  ASSERT_TRUE(server) << server.error().message;
  const auto answered = who_answers(rig.endpoint, {}, kPatienceS);
  ASSERT_TRUE(answered) << answered.error().message;
  EXPECT_EQ(answered->who, Answer::physics_server);
  EXPECT_EQ(answered->role, Role::operator_);
}

TEST(Probe, WhoeverListensAndSaysNothingIsAStranger) {
  testing::ZmqRig rig;
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  rig.endpoint.socket.string().copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  ASSERT_EQ(::listen(fd, 4), 0);
  const auto answered = who_answers(rig.endpoint, {}, 0.1);
  ASSERT_TRUE(answered) << answered.error().message;
  EXPECT_EQ(answered->who, Answer::stranger);
  ::close(fd);
  EXPECT_FALSE(somebody_listens(rig.endpoint.socket));  // as after a server's death
  EXPECT_TRUE(std::filesystem::is_socket(rig.endpoint.socket));
}

TEST(Probe, AServerWithOurOwnKeyIsKnownThoughItDoesNotAdmitUs) {
  testing::ZmqRig rig;
  const auto pair = *make_key_pair();
  ASSERT_TRUE(write_key_pair(rig.scratch / "keys", pair, false));
  const auto any = *parse_endpoint("tcp://127.0.0.1:*", EndpointUse::listen);
  const auto server = serve_states(any, rig.physics_clock, testing::state_at, testing::table_scene(),
                                   {*server_identity(rig.scratch / "keys"), {}});
  ASSERT_TRUE(server) << server.error().message;
  const auto place = *parse_endpoint((*server)->endpoint(), EndpointUse::connect);
  const auto answered = who_answers(place, ClientIdentity{pair, pair.public_key}, kPatienceS);
  ASSERT_TRUE(answered) << answered.error().message;
  EXPECT_EQ(answered->who, Answer::not_admitted);

  const auto taken = can_listen(place);
  EXPECT_FALSE(taken.possible);
  EXPECT_TRUE(taken.in_use);
}

TEST(Probe, ListeningIsTriedWithoutLeavingAnything) {
  const auto any = *parse_endpoint("tcp://127.0.0.1:*", EndpointUse::listen);
  EXPECT_TRUE(can_listen(any).possible);
  // Of documentation (RFC 5737): no machine has it.
  const auto elsewhere = can_listen(*parse_endpoint("tcp://192.0.2.1:5555", EndpointUse::listen));
  EXPECT_FALSE(elsewhere.possible);
  EXPECT_FALSE(elsewhere.in_use);
  EXPECT_FALSE(elsewhere.reason.empty());
}

TEST(Probe, TheLibrariesNameThemselves) {
  const auto libraries = network_libraries();
  EXPECT_TRUE(libraries.zeromq.starts_with("4.")) << libraries.zeromq;
  EXPECT_FALSE(libraries.protobuf.empty());
  EXPECT_GT(libraries.protocol, 0u);
}

}  // namespace
}  // namespace palpate::transport
