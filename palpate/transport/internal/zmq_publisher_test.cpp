// Observers over the real wire: who gets states, who gets none, and what ill will costs the others.
#include "palpate/transport/internal/zmq_publisher.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <zmq.h>

#include <filesystem>
#include <functional>
#include <map>
#include <set>

#include "palpate/transport/guarded_server_test.h"
#include "palpate/transport/messages.h"

namespace palpate::transport {
namespace {

using std::chrono::milliseconds;
using testing::GuardedServer;
using testing::ZmqRig;

// An observer that says what it likes.
class Observer {
 public:
  explicit Observer(const std::string& address, const std::optional<ClientIdentity>& identity = {},
                    int type = ZMQ_DEALER)
      : socket(std::move(*zmq::Socket::make(type))) {
    EXPECT_TRUE(!identity || zmq::encrypt(socket, *identity));
    EXPECT_TRUE(socket.receive_without_bound());
    EXPECT_EQ(zmq_connect(socket.get(), address.c_str()), 0);
  }
  bool subscribe(int rate_hz) { return socket.send(encode(ClientMessage(Subscribe{rate_hz}))); }
  // The next thing said to it.
  std::optional<ServerMessage> hears() {
    std::string body;
    if (!socket.readable() || socket.receive(1, nullptr, body) != zmq::Socket::Received::message) return {};
    auto message = decode_server_message(body);
    EXPECT_TRUE(message) << message.error().message;
    return message ? std::optional(std::move(*message)) : std::nullopt;
  }
  bool gets_a_state(ZmqRig& rig) {
    return rig.until({}, [&] {
      const auto heard = hears();
      return heard && std::holds_alternative<StateReply>(*heard);
    });
  }
  std::string refusal(ZmqRig& rig) {
    std::string reason;
    rig.until({}, [&] {
      const auto heard = hears();
      if (heard && std::holds_alternative<Refusal>(*heard)) reason = std::get<Refusal>(*heard).reason;
      return !reason.empty();
    });
    return reason;
  }

  zmq::Socket socket;
};

bool sends(ZmqRig& rig, Observer& observer, const std::string& bytes) {
  return rig.until({}, [&] { return observer.socket.send(bytes); });
}

std::string states_of(const ZmqRig& rig) { return rig.endpoint.address + ".states"; }

// States came all the while, in order, to the last: nothing was lost, and none is older than a moment.
void expect_served(ZmqRig& rig, StateWatch& watch, std::size_t states = 10) {
  std::size_t count = 0;
  EXPECT_TRUE(rig.until({}, [&] { return watch.take().has_value() && ++count >= states; }));
  EXPECT_EQ(watch.counters().missed, 0u);
  EXPECT_EQ(watch.counters().rejected, 0u);
}

TEST(StatesSocket, ASubscriptionLastsAsLongAsItIsRenewed) {
  ZmqRig rig;
  auto server = rig.serve();
  Observer observer(states_of(rig));
  ASSERT_TRUE(sends(rig, observer, encode(ClientMessage(Subscribe{100}))));
  ASSERT_TRUE(observer.gets_a_state(rig));
  auto last = rig.physics_clock.now();
  const auto begun = last;
  ASSERT_TRUE(rig.until({}, [&] {
    if (observer.hears()) last = rig.physics_clock.now();
    return rig.physics_clock.now() - last > milliseconds(500);
  }));
  EXPECT_GT(last - begun, Subscriptions::kLease - milliseconds(500));
  ASSERT_TRUE(observer.subscribe(100));
  EXPECT_TRUE(observer.gets_a_state(rig));
}

TEST(StatesSocket, AConnectionHasOneSubscriptionAndTheNewOneReplacesTheOld) {
  ZmqRig rig;
  auto server = rig.serve();
  Observer observer(states_of(rig));
  ASSERT_TRUE(sends(rig, observer, encode(ClientMessage(Subscribe{1000}))));
  ASSERT_TRUE(observer.gets_a_state(rig));
  ASSERT_TRUE(observer.subscribe(1));
  // At 1 Hz it is quiet between two states.
  EXPECT_TRUE(rig.until({}, [&, last = rig.physics_clock.now()]() mutable {
    if (observer.hears()) last = rig.physics_clock.now();
    return rig.physics_clock.now() - last > milliseconds(300);
  }));
}

TEST(StatesSocket, WhatIsNoSubscriptionIsRefusedInWordsAndTheOthersDoNotNotice) {
  ZmqRig rig;
  auto server = rig.serve();
  auto watch = std::move(*watch_states(rig.endpoint, 200));
  expect_served(rig, *watch);
  Observer observer(states_of(rig));
  ASSERT_TRUE(sends(rig, observer, "nonsense"));
  EXPECT_NE(observer.refusal(rig).find("no message"), std::string::npos);
  for (const int rate_hz : {0, 1001, -1}) {
    ASSERT_TRUE(sends(rig, observer, encode(ClientMessage(Subscribe{rate_hz}))));
    EXPECT_NE(observer.refusal(rig).find("rate_hz must be 1 to 1000"), std::string::npos) << rate_hz;
  }
  ASSERT_TRUE(sends(rig, observer, encode(ClientMessage(StateRequest{1, {seconds(1)}}))));
  EXPECT_NE(observer.refusal(rig).find("nothing but subscriptions"), std::string::npos);
  EXPECT_TRUE(observer.socket.send("two", true) && observer.socket.send("frames"));
  EXPECT_TRUE(rig.until({}, [&] { return (*server)->counters().rejected == 6; }));
  ASSERT_TRUE(observer.subscribe(100));
  EXPECT_TRUE(observer.gets_a_state(rig));
  expect_served(rig, *watch, 50);
}

TEST(StatesSocket, AFrameAboveTheBoundCostsItsSenderTheConnectionAndTheOthersNothing) {
  ZmqRig rig;
  auto server = rig.serve();
  auto watch = std::move(*watch_states(rig.endpoint, 200));
  expect_served(rig, *watch);
  for (const std::size_t bytes : {zmq::kMaxRequestBytes + 1, std::size_t{60'000}, std::size_t{10'000'000}}) {
    Observer observer(states_of(rig));
    ASSERT_TRUE(sends(rig, observer, encode(ClientMessage(Subscribe{200}))));
    ASSERT_TRUE(observer.gets_a_state(rig));
    ASSERT_TRUE(sends(rig, observer, std::string(bytes, 'x')));
    // What was under way to it comes; nothing else does, though its lease runs on.
    ASSERT_TRUE(rig.until({}, [&, last = rig.physics_clock.now()]() mutable {
      if (observer.hears()) last = rig.physics_clock.now();
      return rig.physics_clock.now() - last > milliseconds(300);
    }));
    expect_served(rig, *watch, 50);
  }
  EXPECT_EQ((*server)->counters().rejected, 0u);  // none of it was read
}

TEST(StatesSocket, SubscriptionsAtTheServersOwnAddressAreRefusedWithTheRightOne) {
  ZmqRig rig;
  auto server = rig.serve();
  Observer observer(rig.endpoint.address);
  ASSERT_TRUE(sends(rig, observer, encode(ClientMessage(Subscribe{100}))));
  EXPECT_NE(observer.refusal(rig).find(states_of(rig)), std::string::npos);
}

TEST(StatesSocket, AProcessHasABoundOfItsOwnAndThoseThereDoNotNotice) {
  ZmqRig rig;
  auto server = rig.serve();
  auto watch = std::move(*watch_states(rig.endpoint, 100));
  expect_served(rig, *watch);
  std::map<std::size_t, std::unique_ptr<Observer>> many, served;
  for (std::size_t i = 0; i < Connections::kMostOfSource + 8; ++i)
    many[i] = std::make_unique<Observer>(states_of(rig));
  const auto serve_for = [&](Duration time) {
    const auto begun = rig.physics_clock.now();
    rig.until({}, [&, renewed = begun - seconds(1)]() mutable {
      watch->take();
      const bool due = rig.physics_clock.now() - renewed > milliseconds(300);
      if (due) renewed = rig.physics_clock.now();
      for (auto& [i, one] : many) {
        if (due) one->subscribe(20);
        if (one->hears() && !served.contains(i)) served[i] = nullptr;
      }
      return rig.physics_clock.now() - begun > time;
    });
  };
  serve_for(milliseconds(1500));
  EXPECT_EQ(served.size(), Connections::kMostOfSource - 1);  // one is the watch's
  expect_served(rig, *watch, 20);
  // Places come free with their connections, and those that were turned away come by themselves.
  many.erase(served.begin()->first);
  EXPECT_TRUE(rig.until({}, [&] {
    serve_for(milliseconds(100));
    return served.size() > Connections::kMostOfSource - 1;
  }));
}

TEST_F(GuardedServer, ARevokedObserverGetsNothingMoreAndTheOthersDoNotNotice) {
  auto leaving = watch(observer), staying = watch(graphics), stranger = watch(*make_key_pair());
  ASSERT_TRUE(rig.until({}, [&] { return leaving->take().has_value(); }));
  expect_served(rig, *staying);
  const auto open = *parse_endpoint(endpoint.address, EndpointUse::connect, true);
  auto bare = std::move(*watch_states(open, 100));
  ASSERT_TRUE(revoke_keys(scratch.path(), "observer"));
  const auto revoked = rig.physics_clock.now();
  auto last = revoked;
  ASSERT_TRUE(rig.until({}, [&] {
    if (const auto state = leaving->take()) last = state->asked;
    staying->take();
    return rig.physics_clock.now() - last > milliseconds(700);
  }));
  EXPECT_LT(last - revoked, milliseconds(1000));  // looked at every 500
  expect_served(rig, *staying);
  EXPECT_GT((*staying).counters().taken + (*staying).counters().skipped, 50u);
  // It renews what it has no more, a second after the first time.
  const auto rejected = server->counters().rejected;
  ASSERT_TRUE(rig.until({}, [&] {
    EXPECT_FALSE(leaving->take());
    return server->counters().rejected > rejected;
  }));
  EXPECT_FALSE(leaving->refusal());
  EXPECT_FALSE(stranger->take());
  EXPECT_FALSE(bare->take());
  // And in again, without a restart.
  ASSERT_TRUE(authorize_key(scratch.path(), {Role::observer, observer.public_key, "observer"}));
  EXPECT_TRUE(rig.until({}, [&] { return leaving->take().has_value(); }));
}

TEST_F(GuardedServer, AKeyHasABoundOfItsOwnAndWhatIsLeftIsForTheOthers) {
  std::vector<std::unique_ptr<StateWatch>> greedy;
  std::set<StateWatch*> served;
  const auto all_take = [&] {
    for (auto& one : greedy)
      if (one->take()) served.insert(one.get());
  };
  for (std::size_t i = 0; i < Connections::kMostOfKey + 3; ++i) greedy.push_back(watch(observer, 20));
  rig.until({}, [&, begun = rig.physics_clock.now()] {
    all_take();
    return rig.physics_clock.now() - begun > milliseconds(1500);
  });
  EXPECT_EQ(served.size(), Connections::kMostOfKey);
  auto modest = watch(graphics);
  EXPECT_TRUE(rig.until({}, [&] {
    all_take();
    return modest->take().has_value();
  }));
  EXPECT_FALSE(modest->refusal());
  // Where one has gone the next comes in.
  std::erase_if(greedy, [&](const auto& one) { return one.get() == *served.begin(); });
  EXPECT_TRUE(rig.until({}, [&] {
    all_take();
    return served.size() > Connections::kMostOfKey;
  }));
}

// Anything an observer can say, as quickly as it can; what is said to it is thrown away.
void flood(zmq::Socket& socket, int round) {
  std::string answer;
  while (socket.receive(1, nullptr, answer) != zmq::Socket::Received::nothing) continue;
  const std::string small = encode(ClientMessage(Subscribe{1 + round % 1000}));
  if (!socket.send(round % 3 == 0 ? small : round % 3 == 1 ? std::string(300, 'x') : std::string("nonsense")))
    static_cast<void>(socket.readable());
}

TEST_F(GuardedServer, AFloodOfSubscriptionsCostsTheOthersNothing) {
  auto staying = watch(graphics, 200);
  auto link = connect(graphics);
  expect_served(rig, *staying);
  Observer flooding(server->states_endpoint(), ClientIdentity{observer, own.public_key});
  ASSERT_TRUE(sends(rig, flooding, encode(ClientMessage(Subscribe{1000}))));
  ASSERT_TRUE(flooding.gets_a_state(rig));
  const auto until = rig.physics_clock.now() + milliseconds(500);
  std::optional<StateReply> newest;
  for (int round = 0; rig.physics_clock.now() < until; ++round) {
    flood(flooding.socket, round);
    if (round % 100 == 0)
      if (const auto state = staying->take()) newest = state;
  }
  ASSERT_TRUE(newest);
  EXPECT_TRUE(gets_a_state(*link, 1));
  EXPECT_TRUE(rig.until({}, [&] { return server->counters().rejected > 100; }));
  expect_served(rig, *staying);
  EXPECT_EQ(server->counters().rejected_connections, 0u);
}

// Holds this process, server and clients, to so many descriptors.
class DescriptorLimit {
 public:
  explicit DescriptorLimit(std::ptrdiff_t more_than_used) {
    getrlimit(RLIMIT_NOFILE, &before_);
    namespace fs = std::filesystem;
    const auto used = std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()) - 1;
    rlimit now = before_;
    now.rlim_cur = static_cast<rlim_t>(used + more_than_used);
    EXPECT_EQ(setrlimit(RLIMIT_NOFILE, &now), 0);
  }
  ~DescriptorLimit() { setrlimit(RLIMIT_NOFILE, &before_); }
  DescriptorLimit(const DescriptorLimit&) = delete;
  DescriptorLimit& operator=(const DescriptorLimit&) = delete;

 private:
  rlimit before_{};
};

class FewDescriptors : public GuardedServer {
 protected:
  // A list of keys made beforehand: renaming takes no descriptor.
  void prepare(const std::string& name, const std::vector<AuthorizedKey>& keys) {
    for (const auto& key : keys) ASSERT_TRUE(authorize_key(scratch / name, key));
  }
  void use(const std::string& name) {
    std::filesystem::copy_file(scratch / name / "authorized_keys", scratch / "next",
                               std::filesystem::copy_options::overwrite_existing);
  }
  void put_in_place() { std::filesystem::rename(scratch / "next", scratch / "authorized_keys"); }

  // With no descriptor to spare, one, two ...: `harm` is done, the server lives and answers, and when there
  // are descriptors again a new observer comes in.
  void expect_nothing_happens(const std::function<void()>& before, const std::function<void()>& harm) {
    auto link = connect(chief);
    auto staying = watch(graphics, 100);
    std::uint64_t number = 0;
    ASSERT_TRUE(gets_a_state(*link, ++number));
    expect_served(rig, *staying);
    for (std::ptrdiff_t more = -3; more <= 3; ++more) {
      SCOPED_TRACE(more);
      before();
      {
        const DescriptorLimit limit(more);
        harm();
        EXPECT_TRUE(gets_a_state(*link, ++number));
        expect_served(rig, *staying);
      }
      const auto lifted = rig.physics_clock.now();
      auto coming = watch(graphics, 100);
      EXPECT_TRUE(rig.until({}, [&] { return coming->take().has_value(); }));
      EXPECT_LT(rig.physics_clock.now() - lifted, std::chrono::seconds(2));
      expect_served(rig, *staying);
    }
  }
};

TEST_F(FewDescriptors, AKeyThatIsRevokedLosesItsStatesAndTheServerLives) {
  const AuthorizedKey first{Role::graphics, graphics.public_key, ""},
      second{Role::operator_, chief.public_key, ""};
  prepare("all", {first, second, {Role::observer, observer.public_key, ""}});
  prepare("without", {first, second});
  std::unique_ptr<StateWatch> leaving;
  expect_nothing_happens(
      [&] {
        use("all");
        put_in_place();
        const auto changed = rig.physics_clock.now();  // the list is looked at twice a second
        rig.until({}, [&] { return rig.physics_clock.now() - changed > milliseconds(600); });
        leaving = watch(observer);
        ASSERT_TRUE(rig.until({}, [&] { return leaving->take().has_value(); }));
        use("without");
      },
      [&] {
        put_in_place();
        EXPECT_TRUE(rig.until({}, [&, last = rig.physics_clock.now()]() mutable {
          if (leaving->take()) last = rig.physics_clock.now();
          return rig.physics_clock.now() - last > milliseconds(300);
        }));
      });
}

TEST_F(FewDescriptors, AFloodOfSubscriptionsLeavesTheServerAlive) {
  std::unique_ptr<Observer> flooding;
  expect_nothing_happens(
      [&] {
        flooding =
            std::make_unique<Observer>(server->states_endpoint(), ClientIdentity{observer, own.public_key});
        ASSERT_TRUE(sends(rig, *flooding, encode(ClientMessage(Subscribe{10}))));
        ASSERT_TRUE(flooding->gets_a_state(rig));
      },
      [&] {
        const auto rejected = server->counters().rejected;
        for (int round = 0; round < 3000; ++round) flood(flooding->socket, round);
        EXPECT_TRUE(rig.until({}, [&] { return server->counters().rejected > rejected; }));
        sends(rig, *flooding, std::string(60'000, 'x'));
      });
}

// An observer of a release that subscribed by topics.
TEST_F(GuardedServer, TopicsOfAnEarlierReleaseAreNothingToTheServer) {
  auto staying = watch(graphics);
  expect_served(rig, *staying);
  Observer of_old(server->states_endpoint(), ClientIdentity{observer, own.public_key}, ZMQ_SUB);
  for (int i = 0; i < 300; ++i) {
    const std::string topic = std::to_string(i) + std::string(2000, 'x');
    zmq_setsockopt(of_old.socket.get(), ZMQ_SUBSCRIBE, topic.data(), topic.size());
    rig.wait_a_little();
    static_cast<void>(of_old.socket.readable());
    staying->take();
  }
  expect_served(rig, *staying);
  EXPECT_EQ(server->counters().rejected, 0u);
}

}  // namespace
}  // namespace palpate::transport
