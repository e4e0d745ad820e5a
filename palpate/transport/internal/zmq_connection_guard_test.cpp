// Connections that nobody needs, over the real wire: they end, and whoever has something to say gets in.
#include "palpate/transport/internal/zmq_connection_guard.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <zmq.h>

#include "palpate/transport/guarded_server_test.h"
#include "palpate/transport/internal/zmq_authenticator.h"

namespace palpate::transport {
namespace {

using std::chrono::milliseconds;
using testing::GuardedServer;

// A bare connection to a server of this machine, which says nothing.
class Stranger {
 public:
  explicit Stranger(const std::string& address) : descriptor_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    place.sin_port = htons(static_cast<std::uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
    EXPECT_EQ(connect(descriptor_, reinterpret_cast<const sockaddr*>(&place), sizeof place), 0);
  }
  ~Stranger() { close(descriptor_); }
  Stranger(const Stranger&) = delete;
  Stranger& operator=(const Stranger&) = delete;
  // The other side has accepted it, and says what it speaks.
  bool is_greeted() const {
    char byte = 0;
    return recv(descriptor_, &byte, 1, 0) == 1;
  }
  // The other side has closed it; what it said before, a greeting, is passed over.
  bool ended() const {
    char bytes[256];
    ssize_t got = 0;
    while ((got = recv(descriptor_, bytes, sizeof bytes, MSG_DONTWAIT)) > 0) continue;
    return got == 0 || errno == ECONNRESET;
  }

 private:
  int descriptor_;
};

std::size_t still_there(const std::vector<std::unique_ptr<Stranger>>& strangers) {
  return static_cast<std::size_t>(
      std::count_if(strangers.begin(), strangers.end(), [](const auto& one) { return !one->ended(); }));
}

TEST_F(GuardedServer, StrangersHoldSoManyConnectionsAndAnOperatorGetsIn) {
  std::vector<std::unique_ptr<Stranger>> strangers;
  for (int i = 0; i < 10; ++i) {
    for (int k = 0; k < 50; ++k) strangers.push_back(std::make_unique<Stranger>(endpoint.address));
    auto link = connect(chief);
    EXPECT_TRUE(gets_a_state(*link, 1)) << i;
    EXPECT_LE(still_there(strangers), Connections::kMostNew + 50);
  }
}

// The listener stays open here: what ends its connections is the guard.
TEST(ConnectionGuard, WhoeverLeavesHasEndedItsOwnConnectionsAndNoOthers) {
  const MonotonicClock<PhysicsClock> clock{100.0, 0.0};
  const auto context = *zmq::make_context();
  auto guard = std::move(*zmq::ConnectionGuard::make(clock));
  std::vector<zmq::Socket> listeners;
  std::vector<std::vector<std::unique_ptr<Stranger>>> strangers(2);
  for (auto& of_one : strangers) {
    listeners.push_back(std::move(*zmq::Socket::make(ZMQ_ROUTER, context)));
    ASSERT_TRUE(guard->watch(listeners.back(), context));
    ASSERT_TRUE(listeners.back().bind("tcp://127.0.0.1:*"));
    for (int i = 0; i < 3; ++i) of_one.push_back(std::make_unique<Stranger>(listeners.back().endpoint()));
    for (const auto& one : of_one) ASSERT_TRUE(one->is_greeted());
  }
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(still_there(strangers[i]), 3u);
    guard->leave(listeners[i]);
    EXPECT_EQ(still_there(strangers[i]), 0u);
  }
}

// A key is admitted, its connections say nothing: handshakes alone hold no place.
TEST_F(GuardedServer, ConnectionsThatSayNothingEndAndTheOthersStay) {
  auto staying = connect(graphics);
  ASSERT_TRUE(gets_a_state(*staying, 1));
  std::vector<zmq::Socket> silent;
  for (int i = 0; i < 5; ++i) {
    auto socket = std::move(*zmq::Socket::make(ZMQ_DEALER));
    ASSERT_TRUE(zmq::encrypt(socket, ClientIdentity{observer, own.public_key}));
    const int never = -1;
    zmq_setsockopt(socket.get(), ZMQ_RECONNECT_IVL, &never, sizeof never);
    ASSERT_EQ(zmq_connect(socket.get(), endpoint.address.c_str()), 0);
    silent.push_back(std::move(socket));
  }
  const auto connected = [&] {
    return std::count_if(silent.begin(), silent.end(), [](zmq::Socket& one) {
      int events = 0;
      std::size_t size = sizeof events;
      zmq_getsockopt(one.get(), ZMQ_EVENTS, &events, &size);
      return (events & ZMQ_POLLOUT) != 0;
    });
  };
  ASSERT_TRUE(rig.until({staying.get()}, [&] { return connected() == 5; }));
  EXPECT_TRUE(rig.until({staying.get()}, [&] { return connected() == 0; }));
  EXPECT_TRUE(gets_a_state(*staying, 2));
  EXPECT_EQ(staying->counters().lost, 0u);
}

TEST_F(GuardedServer, AClientOfAKeyWithTooManyConnectionsIsToldWhy) {
  std::vector<std::unique_ptr<StateLink>> links;
  for (std::size_t i = 0; i < Connections::kMostOfKey; ++i) {
    links.push_back(connect(graphics));
    ASSERT_TRUE(gets_a_state(*links.back(), 1)) << i;
  }
  auto late = connect(graphics);
  const auto poll_all = [&] {
    for (auto& one : links) one->poll();
  };
  EXPECT_TRUE(rig.until({late.get()}, [&] {
    poll_all();
    return late->trouble().has_value();
  }));
  EXPECT_EQ(late->trouble_kind(), LinkTrouble::no_place) << *late->trouble();
  links.pop_back();
  EXPECT_TRUE(rig.until({late.get()}, [&] {
    poll_all();
    return late->peer_alive();
  }));
}

}  // namespace
}  // namespace palpate::transport
