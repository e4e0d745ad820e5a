#include "palpate/transport/internal/server_connection.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <vector>

#include "palpate/core/file_descriptor.h"

namespace palpate::transport::zmq {
namespace {

// Both ends of a connection over the loopback.
class Ends {
 public:
  Ends() {
    const FileDescriptor listener(::socket(AF_INET, SOCK_STREAM, 0));
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof place;
    auto* address = reinterpret_cast<sockaddr*>(&place);
    EXPECT_EQ(::bind(listener.get(), address, size), 0);
    EXPECT_EQ(::listen(listener.get(), 1), 0);
    EXPECT_EQ(::getsockname(listener.get(), address, &size), 0);
    client = FileDescriptor(::socket(AF_INET, SOCK_STREAM, 0));
    const int room = 256 << 10;  // of what is not read yet
    EXPECT_EQ(::setsockopt(client.get(), SOL_SOCKET, SO_RCVBUF, &room, sizeof room), 0);
    EXPECT_EQ(::connect(client.get(), address, size), 0);
    server = FileDescriptor(::accept(listener.get(), nullptr, nullptr));
  }
  // So many bytes from server to client; read there, or not.
  void send(std::size_t bytes, bool read) {
    std::vector<char> part(16 << 10);
    for (std::size_t sent = 0; sent < bytes; sent += part.size()) {
      EXPECT_EQ(::send(server.get(), part.data(), part.size(), 0), static_cast<ssize_t>(part.size()));
      if (read) {
        EXPECT_EQ(::recv(client.get(), part.data(), part.size(), MSG_WAITALL),
                  static_cast<ssize_t>(part.size()));
      }
    }
  }
  // Bytes that lie at the client, once there are so many.
  std::size_t unread(std::size_t bytes) {
    int there = 0;
    for (int i = 0; i < 2000 && there < static_cast<int>(bytes); ++i) {
      EXPECT_EQ(::ioctl(client.get(), FIONREAD, &there), 0);
      ::usleep(1000);
    }
    return static_cast<std::size_t>(there);
  }
  bool open() {
    char byte = 0;
    return ::recv(server.get(), &byte, 1, MSG_DONTWAIT) < 0;
  }
  FileDescriptor client, server;
};

constexpr Instant<GraphicsClock> kNow{std::chrono::seconds(5)};

TEST(ServerConnection, MoreMessagesThanAnybodyAsksForAreAFlood) {
  Ends ends;
  ServerConnection connection;
  connection.began(ends.client.get());
  for (std::size_t i = 0; i < ServerConnection::kMostMessages; ++i) ASSERT_TRUE(connection.count(100, kNow));
  EXPECT_FALSE(connection.too_much());
  EXPECT_FALSE(connection.count(100, kNow));
  EXPECT_TRUE(connection.too_much());
  EXPECT_FALSE(connection.count(100, kNow + std::chrono::seconds(1))) << "it stays one until it has ended";
  EXPECT_TRUE(ends.open());
  connection.end();
  EXPECT_FALSE(ends.open());
  EXPECT_FALSE(connection.there());
  EXPECT_FALSE(connection.too_much()) << "it has ended";
  connection.ended();
  EXPECT_TRUE(connection.count(100, kNow + std::chrono::seconds(2)));
}

TEST(ServerConnection, AsManyASecondAreNone) {
  Ends ends;
  ServerConnection connection;
  connection.began(ends.client.get());
  for (int tenth = 0; tenth < 50; ++tenth)
    for (std::size_t i = 0; i < ServerConnection::kMostMessages / 2; ++i)
      ASSERT_TRUE(connection.count(1000, kNow + tenth * std::chrono::milliseconds(100)));
}

TEST(ServerConnection, SoAreMoreBytes) {
  ServerConnection connection;
  std::size_t messages = 0;
  while (connection.count(960'000, kNow)) ++messages;
  EXPECT_EQ(messages, ServerConnection::kMostBytes / 960'000);
}

TEST(ServerConnection, AMessageWithoutAnEndIsTooMuchAndOneThatWaitsToBeReadIsNot) {
  Ends ends;
  ServerConnection connection;
  connection.began(ends.client.get());
  ends.send(150'000, true);
  EXPECT_FALSE(connection.too_much());
  EXPECT_TRUE(connection.count(150'000, kNow));
  EXPECT_FALSE(connection.too_much());
  ends.send(150'000, true);
  EXPECT_FALSE(connection.too_much()) << "counted from the last whole one";
  ends.send(100'000, true);
  EXPECT_TRUE(connection.too_much());
  EXPECT_TRUE(connection.count(64 << 10, kNow));
  EXPECT_FALSE(connection.too_much());
  ends.send(64 << 10, false);
  EXPECT_FALSE(connection.too_much());
  connection.expect(1'000'000);
  ends.send(1'000'000, true);
  EXPECT_FALSE(connection.too_much()) << "a shape";
}

// Of a message of 1 kB the bound is just beyond the slack; what libzmq has not read counts for nothing.
TEST(ServerConnection, WhatWaitsToBeReadIsNoMessageWithoutAnEnd) {
  Ends ends;
  ServerConnection connection;
  connection.began(ends.client.get());
  connection.expect(1000);
  const std::size_t waiting = 2 * ServerConnection::kSlackBytes;
  ends.send(waiting, false);
  ASSERT_EQ(ends.unread(waiting), waiting);
  EXPECT_FALSE(connection.too_much());
  std::vector<char> all(waiting);
  ASSERT_EQ(::recv(ends.client.get(), all.data(), waiting, MSG_WAITALL), static_cast<ssize_t>(waiting));
  EXPECT_TRUE(connection.too_much());
}

TEST(ServerConnection, OfOneThatHasEndedNothingCountsForTheNext) {
  Ends first, second;
  ServerConnection connection;
  connection.began(first.client.get());
  first.send(1'000'000, true);
  EXPECT_TRUE(connection.count(1'000'000, kNow));
  EXPECT_FALSE(connection.too_much());
  EXPECT_TRUE(connection.count(100, kNow));
  connection.ended();
  EXPECT_FALSE(connection.there());
  connection.end();
  EXPECT_TRUE(first.open()) << "it is another's now";
  connection.began(second.client.get());
  second.send(400'000, true);
  EXPECT_TRUE(connection.too_much()) << "no message of its own has come";
  while (connection.count(ServerConnection::kMostBytes, kNow)) {
  }
  connection.began(first.client.get());
  EXPECT_TRUE(connection.count(100, kNow + std::chrono::seconds(1))) << "nor is it a flood";
}

TEST(ServerConnection, AnotherSocketThatHasGotItsDescriptorStaysOpen) {
  Ends one, other;
  ServerConnection connection;
  connection.began(one.client.get());
  ASSERT_EQ(::dup2(other.client.get(), one.client.get()), one.client.get());
  connection.end();
  EXPECT_TRUE(other.open());
}

}  // namespace
}  // namespace palpate::transport::zmq
