#include "tools/demo/two_hosts.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <optional>
#include <string>

namespace palpate::tools::demo {
namespace {

// Datagrams between the hosts: they tell at once whether the cable carries anything.
class TwoHostsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto made = TwoHosts::make();
    ASSERT_TRUE(made) << made.error().message;
    hosts_.emplace(std::move(*made));
    ASSERT_TRUE(hosts_->at(TwoHosts::kPhysicsHost, [&] { listener_ = ::socket(AF_INET, SOCK_DGRAM, 0); }));
    ASSERT_TRUE(hosts_->at(TwoHosts::kGraphicsHost, [&] { sender_ = ::socket(AF_INET, SOCK_DGRAM, 0); }));
    const auto place = place_of_physics();
    ASSERT_EQ(::bind(listener_, reinterpret_cast<const sockaddr*>(&place), sizeof place), 0);
  }
  void TearDown() override {
    if (listener_ >= 0) ::close(listener_);
    if (sender_ >= 0) ::close(sender_);
  }

  static sockaddr_in place_of_physics() {
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_port = htons(9);
    ::inet_pton(AF_INET, TwoHosts::kPlaces[TwoHosts::kPhysicsHost], &place.sin_addr);
    return place;
  }

  // Whether one of up to `tries` datagrams arrives, 10 ms each.
  bool arrives(int tries) const {
    const timeval patience{.tv_sec = 0, .tv_usec = 10'000};
    ::setsockopt(listener_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    const auto place = place_of_physics();
    for (int i = 0; i < tries; ++i) {
      ::sendto(sender_, "x", 1, MSG_DONTWAIT, reinterpret_cast<const sockaddr*>(&place), sizeof place);
      char got = 0;
      if (::recv(listener_, &got, 1, 0) == 1) return true;
    }
    return false;
  }

  std::optional<TwoHosts> hosts_;
  int listener_ = -1, sender_ = -1;
};

TEST_F(TwoHostsTest, TalkOverTheCableAndOnlyWhileItIsIn) {
  EXPECT_TRUE(arrives(1000));
  ASSERT_TRUE(hosts_->plug(false));
  while (arrives(1)) {
  }  // what was under way
  EXPECT_FALSE(arrives(20));
  ASSERT_TRUE(hosts_->plug(true));
  EXPECT_TRUE(arrives(1000));
}

TEST_F(TwoHostsTest, AreInNetworksOfTheirOwn) {
  const auto network = [] {
    std::array<char, 64> name{};
    const ssize_t size = ::readlink("/proc/thread-self/ns/net", name.data(), name.size());
    return std::string(name.data(), static_cast<std::size_t>(size > 0 ? size : 0));
  };
  std::string physics, graphics;
  ASSERT_TRUE(hosts_->at(TwoHosts::kPhysicsHost, [&] { physics = network(); }));
  ASSERT_TRUE(hosts_->at(TwoHosts::kGraphicsHost, [&] { graphics = network(); }));
  EXPECT_NE(physics, graphics);
  EXPECT_NE(physics, network());
  EXPECT_NE(graphics, network());
}

// Both stand at the same two addresses, and neither hears of the other.
TEST_F(TwoHostsTest, CanBeThereTwice) {
  const auto others = TwoHosts::make();
  ASSERT_TRUE(others) << others.error().message;
  ASSERT_TRUE(others->plug(false));
  EXPECT_TRUE(arrives(1000));
}

}  // namespace
}  // namespace palpate::tools::demo
