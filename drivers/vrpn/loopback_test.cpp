// Server and client over real sockets of this machine. Nothing here measures time: waits are for what must
// come, however long a busy machine takes.
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include "drivers/network/socket.h"
#include "drivers/vrpn/message_stream.h"
#include "drivers/vrpn/protocol.h"
#include "tests/comes_true.h"

namespace palpate::drivers::vrpn {
namespace {

using tests::comes_true;
using Stamp = Instant<TrackerClock>;

network::RigidPose somewhere(int i) {
  return {so3_exp(Vector3(0.1, 0.01 * i, 0.2)), Vector3(0.1 * i, -0.2, 1.0)};
}

std::unique_ptr<network::PoseServer> server_at(std::uint16_t port = 0) {
  auto server = listen({"127.0.0.1", port});
  EXPECT_TRUE(server.has_value()) << server.error().message;
  return server ? std::move(*server) : nullptr;
}

std::unique_ptr<network::PoseClient> client_of(const network::Address& address) {
  auto client = connect(address);
  EXPECT_TRUE(client.has_value()) << client.error().message;
  return client ? std::move(*client) : nullptr;
}

// Publishes until the client has heard of it: it has to be introduced first.
void meet(network::PoseServer& server, network::PoseClient& client) {
  ASSERT_TRUE(comes_true([&] {
    EXPECT_TRUE(server.publish("Hello", {}, somewhere(0)).has_value());
    return client.state().samples > 0;
  }));
  ASSERT_TRUE(server.drain(std::chrono::minutes(2)));
  ASSERT_TRUE(comes_true([&] { return client.state().samples > 0; }));
}

TEST(Loopback, PosesOfSeveralToolsComeWithTheirStamps) {
  const auto server = server_at();
  ASSERT_NE(server, nullptr);
  const auto client = client_of(server->address());
  meet(*server, *client);
  client->poll();
  for (int i = 0; i < 20; ++i)
    for (const char* tool : {"Stylus", "Head"})
      ASSERT_TRUE(
          server->publish(tool, Stamp{Duration(1'000'000'000 + 1'000 * i)}, somewhere(i)).has_value());
  std::vector<network::ToolSample> heard;
  ASSERT_TRUE(comes_true([&] {
    for (auto& sample : client->poll())
      if (sample.tool != "Hello") heard.push_back(sample);
    return heard.size() == 40;
  }));
  for (int i = 0; i < 40; ++i) {
    const auto& sample = heard[static_cast<std::size_t>(i)];
    EXPECT_EQ(sample.tool, i % 2 == 0 ? "Stylus" : "Head");
    EXPECT_EQ(sample.stamp.ns(), 1'000'000'000 + 1'000 * (i / 2));
    EXPECT_TRUE(sample.server_time && sample.seen);
    EXPECT_EQ(sample.pose.translation, somewhere(i / 2).translation) << "float64 on the wire";
  }
  EXPECT_EQ(client->state().messages.refused, 0u);
}

TEST(Loopback, TheClientComesBackByItself) {
  auto server = server_at();
  const auto address = server->address();
  const auto client = client_of(address);
  meet(*server, *client);
  server.reset();
  ASSERT_TRUE(comes_true([&] { return !client->state().connected; }));
  client->poll();
  const auto before = client->state().samples;
  server = server_at(address.port);
  ASSERT_TRUE(comes_true([&] {
    EXPECT_TRUE(server->publish("Hello", {}, somewhere(1)).has_value());
    return client->state().samples > before;
  }));
  EXPECT_EQ(client->state().connections, 2u);
}

// A recording begins with its first client, whose version may still be on its way.
TEST(Loopback, PosesThatComeBeforeTheClientsVersionAreNotLost) {
  const auto server = server_at();
  const auto to = network::resolve(server->address())->front();
  const FileDescriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  ASSERT_EQ(::connect(socket.get(), reinterpret_cast<const sockaddr*>(&to.storage), to.size), 0);
  ASSERT_TRUE(comes_true([&] { return server->state().clients == 1; }));
  for (int i = 0; i < 3; ++i)
    ASSERT_TRUE(server->publish("Stylus", Stamp{Duration(1'000 * i)}, somewhere(i)).has_value());
  EXPECT_FALSE(server->drain(std::chrono::milliseconds(50))) << "they wait for it";
  const std::string hello = cookie();
  ASSERT_EQ(::send(socket.get(), hello.data(), hello.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(hello.size()));
  MessageStream stream;
  std::vector<Vector3> heard;
  char bytes[4096];
  while (heard.size() < 3) {
    pollfd item{socket.get(), POLLIN, 0};
    ASSERT_EQ(::poll(&item, 1, 60'000), 1);
    const ssize_t count = ::recv(socket.get(), bytes, sizeof bytes, 0);
    ASSERT_GT(count, 0);
    ASSERT_TRUE(stream.take({bytes, static_cast<std::size_t>(count)}, [&](Message&& message) {
      if (message.type >= 0)
        if (const auto pose = decode_pose(message.payload)) heard.push_back(pose->pose.translation);
    }));
  }
  for (int i = 0; i < 3; ++i) EXPECT_EQ(heard[static_cast<std::size_t>(i)], somewhere(i).translation);
  EXPECT_TRUE(server->drain(std::chrono::minutes(2)));
}

// A client of the library asks by a datagram, waits for the server's connection, and pings the devices it wants.
TEST(Loopback, WhoAsksByDatagramIsConnectedToAndAnswered) {
  const auto server = server_at();
  ASSERT_TRUE(server->publish("Stylus", {}, somewhere(1)).has_value());
  auto waits = network::listen_at({"127.0.0.1", 0});
  ASSERT_TRUE(waits.has_value());
  const FileDescriptor datagrams(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const auto to = network::resolve(server->address())->front();
  const auto ask = [&](const std::string& words) {
    EXPECT_EQ(::sendto(datagrams.get(), words.c_str(), words.size() + 1, 0,
                       reinterpret_cast<const sockaddr*>(&to.storage), to.size),
              static_cast<ssize_t>(words.size() + 1));
  };
  for (const char* nonsense : {"", "hello", "host port", "127.0.0.1 22", "127.0.0.1 70000"}) ask(nonsense);
  ask(fmt::format("somewhere.else {}", waits->address.port));  // only the machine that asked is connected to
  pollfd item{waits->socket.get(), POLLIN, 0};
  ASSERT_EQ(::poll(&item, 1, 60'000), 1);
  const auto socket = network::accept_from(waits->socket);
  ASSERT_TRUE(socket);
  std::string hello = cookie() + *encode({Stamp{}, 0, kSenderDescription, encode_name("Stylus")}) +
                      *encode({Stamp{}, 5, kTypeDescription, encode_name(kPingType)}) +
                      *encode({Stamp{}, 0, 5, ""});
  EXPECT_EQ(::send(socket.get(), hello.data(), hello.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(hello.size()));
  MessageStream stream;
  std::map<std::int32_t, std::string> devices, types;
  int pongs = 0;
  ASSERT_TRUE(comes_true([&] {
    char buffer[4096];
    const auto count = ::recv(socket.get(), buffer, sizeof buffer, MSG_DONTWAIT);
    if (count > 0)
      stream.take({buffer, static_cast<std::size_t>(count)}, [&](Message&& message) {
        if (message.type == kSenderDescription) devices[message.sender] = *decode_name(message.payload);
        if (message.type == kTypeDescription) types[message.sender] = *decode_name(message.payload);
        pongs += types[message.type] == kPongType && devices[message.sender] == "Stylus";
      });
    return pongs == 1;
  }));
  EXPECT_EQ(server->state().clients, 1u);
}

TEST(Loopback, WhoSpeaksSomethingElseIsThrownOut) {
  const auto server = server_at();
  auto socket = network::begin_connect(network::resolve(server->address())->front());
  pollfd item{socket.get(), POLLOUT, 0};
  ASSERT_EQ(::poll(&item, 1, 60'000), 1);
  const std::string browser = "GET / HTTP/1.1\r\nHost: localhost\r\nAccept: text/html\r\n\r\n";
  EXPECT_EQ(::send(socket.get(), browser.data(), browser.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(browser.size()));
  EXPECT_TRUE(comes_true([&] { return server->state().thrown_out == 1; }));
}

TEST(Loopback, AServerThatTalksNonsenseIsLeftAndTriedAgain) {
  auto server = network::listen_at({"127.0.0.1", 0});
  ASSERT_TRUE(server.has_value());
  const auto client = client_of(server->address);
  const auto accept = [&] {
    pollfd item{server->socket.get(), POLLIN, 0};
    EXPECT_EQ(::poll(&item, 1, 60'000), 1);
    return network::accept_from(server->socket);
  };
  const auto send = [](const FileDescriptor& socket, const std::string& bytes) {
    EXPECT_EQ(::send(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  };
  send(accept(), std::string(200, 'x'));
  const auto again = accept();
  ASSERT_TRUE(again);
  EXPECT_NE(client->state().trouble.find("not VRPN"), std::string::npos);
  send(again, cookie() + *encode({Stamp{}, 0, kSenderDescription, encode_name("Tracker0")}) +
                  *encode({Stamp{}, 9, kTypeDescription, encode_name(kPoseType)}) +
                  *encode({Stamp{}, 0, 9, "too short"}) +
                  *encode({Stamp{}, 1, 9, encode_pose({0, somewhere(1)})}) +
                  *encode({Stamp{}, 0, 9, encode_pose({4, somewhere(2)})}));
  ASSERT_TRUE(comes_true([&] { return client->state().samples == 1; }));
  EXPECT_EQ(client->poll().front().tool, "Tracker0:4");
  EXPECT_EQ(client->state().messages.refused, 1u) << "too short";
  EXPECT_EQ(client->state().messages.skipped, 1u) << "of a device nobody has introduced";
}

TEST(Loopback, WhatHasNoPlaceInTheProtocolIsRefused) {
  const auto server = server_at();
  EXPECT_FALSE(server->publish("", {}, somewhere(1)));
  EXPECT_FALSE(server->publish(std::string(200, 'x'), {}, somewhere(1)));
  EXPECT_FALSE(server->publish("a", Stamp{Duration(-5)}, somewhere(1)));
  EXPECT_FALSE(server->publish("a", {}, {Quaternion::Identity(), Vector3(std::nan(""), 0, 0)}));
  const auto second = listen(server->address());
  ASSERT_FALSE(second.has_value());
  EXPECT_NE(second.error().message.find("choose another port"), std::string::npos);
}

}  // namespace
}  // namespace palpate::drivers::vrpn
