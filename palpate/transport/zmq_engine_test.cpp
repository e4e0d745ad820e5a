// What only the real wire can do wrong: processes that die or stand still, peers that talk nonsense,
// addresses.
#include "palpate/transport/zmq_engine.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <zmq.h>

#include <atomic>
#include <chrono>
#include <optional>
#include <thread>

#include "palpate/time/clock_model.h"
#include "palpate/transport/zmq_rig_test.h"
#include "palpate/transport/zmq_socket.h"

namespace palpate::transport {
namespace {

using testing::state_at;
using testing::table_scene;
using testing::ZmqRig;

TEST(ZmqEngine, TheSocketFileIsTheUsersAlone) {
  ZmqRig rig;
  auto server = rig.serve();
  ASSERT_TRUE(server) << server.error().message;
  struct stat info {};
  ASSERT_EQ(lstat(rig.endpoint.socket.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0077, 0u);
  EXPECT_EQ((*server)->endpoint(), rig.endpoint.address);
  server->reset();
  EXPECT_TRUE(std::filesystem::is_empty(rig.scratch.path()));
}

TEST(ZmqEngine, TcpOnAPortOfTheSystemsChoiceAnswersAsWell) {
  const auto listen = parse_endpoint("tcp://127.0.0.1:0", EndpointUse::listen, true);
  ASSERT_TRUE(listen);
  ZmqRig rig(*listen);
  auto server = rig.serve();
  ASSERT_TRUE(server) << server.error().message;
  const auto there = parse_endpoint((*server)->endpoint(), EndpointUse::connect, true);
  ASSERT_TRUE(there) << (*server)->endpoint();
  const auto again = serve_states(*there, rig.physics_clock, state_at, table_scene());
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().message.find("address in use"), std::string::npos) << again.error().message;
  rig.endpoint = *there;
  auto link = rig.connect();
  ASSERT_TRUE(rig.until({link.get()}, [&] { return link->request(1, {seconds(3)}); }));
  EXPECT_TRUE(rig.until({link.get()}, [&] { return link->newest().has_value(); }));
}

TEST(ZmqEngine, AServerKilledInItsTracksLeavesNothingInTheWay) {
  ZmqRig rig;
  // No thread runs in this process yet: the child may do as it likes.
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto server = rig.serve();
    while (server) pause();
    _exit(1);
  }
  auto link = rig.connect();
  ASSERT_TRUE(rig.until({link.get()}, [&] { return link->peer_alive(); }));

  kill(child, SIGSTOP);  // stands still, connection and all: only silence tells
  EXPECT_TRUE(rig.until({link.get()}, [&] { return !link->peer_alive(); }));
  kill(child, SIGCONT);
  EXPECT_TRUE(rig.until({link.get()}, [&] { return link->peer_alive(); }));

  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  EXPECT_TRUE(std::filesystem::is_socket(rig.endpoint.socket));
  EXPECT_TRUE(rig.until({link.get()}, [&] { return !link->peer_alive(); }));
  const std::uint64_t session = link->session();
  auto server = rig.serve();
  ASSERT_TRUE(server) << server.error().message;
  EXPECT_TRUE(rig.until({link.get()}, [&] { return link->peer_alive() && link->session() != session; }));
}

// A peer that says what we tell it to, on the server's side of the wire.
class Rogue {
 public:
  explicit Rogue(const ZmqRig& rig) : socket_(std::move(*zmq::Socket::make(ZMQ_ROUTER))) {
    EXPECT_EQ(zmq_bind(socket_.get(), rig.endpoint.address.c_str()), 0);
  }
  // Takes what has come and remembers who sent it; requests' numbers are kept.
  void listen() {
    std::string peer, body;
    while (socket_.receive(2, &peer, body) == zmq::Socket::Received::message) {
      peer_ = peer;
      const auto message = decode_client_message(body);
      if (!message) continue;
      if (const auto* request = std::get_if<StateRequest>(&*message)) requests.push_back(*request);
    }
  }
  void say(const std::string& bytes) {
    EXPECT_TRUE(socket_.send(peer_, true));
    EXPECT_TRUE(socket_.send(bytes));
  }
  std::vector<StateRequest> requests;

 private:
  zmq::Socket socket_;
  std::string peer_;
};

TEST(ZmqEngine, TheLinkCountsWhatARogueServerDoesAndKeepsGoing) {
  ZmqRig rig;
  Rogue rogue(rig);
  auto link = rig.connect();
  const auto answer = [](std::uint64_t number) {
    return encode(ServerMessage(StateReply{number, {seconds(1)}, state_at({seconds(1)})}));
  };
  ASSERT_TRUE(rig.until({link.get()}, [&] { return link->request(1, {seconds(1)}); }));
  ASSERT_TRUE(link->request(2, {seconds(2)}));
  ASSERT_TRUE(rig.until({link.get()}, [&] {
    rogue.listen();
    return rogue.requests.size() == 2;
  }));
  rogue.say(answer(2));
  rogue.say(answer(1));
  rogue.say(answer(2));
  rogue.say(answer(77));
  rogue.say("nonsense");
  rogue.say("");
  rogue.say(encode(ServerMessage(Refusal{"not you"})));
  ASSERT_TRUE(rig.until({link.get()}, [&] { return link->refusal().has_value(); }));
  EXPECT_EQ(link->newest()->reply.number, 2u);
  EXPECT_EQ(link->counters().replies, 2u);
  EXPECT_EQ(link->counters().out_of_order, 1u);
  EXPECT_EQ(link->counters().duplicated, 1u);
  EXPECT_EQ(link->counters().unknown, 1u);
  EXPECT_EQ(link->counters().rejected, 2u);
  EXPECT_EQ(*link->refusal(), "not you");
}

TEST(ZmqEngine, TheServerRefusesNonsenseInWordsAndServesTheOthers) {
  ZmqRig rig;
  auto server = rig.serve();
  auto link = rig.connect();
  auto rogue = zmq::Socket::make(ZMQ_DEALER);
  ASSERT_TRUE(rogue);
  ASSERT_EQ(zmq_connect(rogue->get(), rig.endpoint.address.c_str()), 0);
  ASSERT_TRUE(rig.until({link.get()}, [&] { return rogue->send("nonsense"); }));
  std::string body;
  ASSERT_TRUE(rig.until({link.get()},
                        [&] { return rogue->receive(1, nullptr, body) == zmq::Socket::Received::message; }));
  const auto message = decode_server_message(body);
  ASSERT_TRUE(message);
  EXPECT_TRUE(std::holds_alternative<Refusal>(*message));

  EXPECT_TRUE(rogue->send("two", true) && rogue->send("frames"));
  ASSERT_TRUE(rig.until({link.get()}, [&] { return (*server)->counters().rejected == 2; }));
  // Longer than anything a client has to say: the engine drops the connection and this side goes on.
  EXPECT_TRUE(rogue->send(std::string(4097, 'x')));
  ASSERT_TRUE(rig.until({link.get()}, [&] { return link->request(1, {seconds(1)}); }));
  EXPECT_TRUE(rig.until({link.get()}, [&] { return link->newest().has_value(); }));
  EXPECT_EQ((*server)->counters().rejected, 2u);
}

// Asks and never reads. It gives no sign of life of its own: with its queue full and its connection ended, that would be
// libzmq's assertion here (Socket::receive_without_bound). Where the server has ended the connection, it comes again.
class ClientThatNeverListens {
 public:
  explicit ClientThatNeverListens(const ZmqRig& rig) : rig_(rig) {}
  bool send(const std::string& request) {
    const auto now = std::chrono::steady_clock::now();
    if (!socket_ || now - sent_ > std::chrono::seconds(1)) {
      const int never = 0;
      socket_.emplace(std::move(*zmq::Socket::make(ZMQ_DEALER)));
      zmq_setsockopt(socket_->get(), ZMQ_HEARTBEAT_IVL, &never, sizeof never);
      EXPECT_EQ(zmq_connect(socket_->get(), rig_.endpoint.address.c_str()), 0);
      sent_ = now;
    }
    if (!socket_->send(request)) return false;
    sent_ = now;
    return true;
  }

 private:
  const ZmqRig& rig_;
  std::optional<zmq::Socket> socket_;
  std::chrono::steady_clock::time_point sent_;
};

TEST(ZmqEngine, WhoTakesNoShapesGetsNoMoreOfThemAndTheOthersStillDo) {
  ZmqRig rig;
  auto server = rig.serve(testing::cloth_scene());
  auto link = rig.connect();
  ClientThatNeverListens stalled(rig);
  const std::string request = encode(ClientMessage(StateRequest{1, {seconds(1)}, true}));
  ASSERT_TRUE(rig.until({link.get()}, [&] {
    stalled.send(request);
    return (*server)->counters().unsent > 0;
  }));
  for (std::uint64_t n = 1; n <= 20; ++n) {
    const Instant<PhysicsClock> time{seconds(static_cast<double>(n))};
    ASSERT_TRUE(rig.until({link.get()}, [&] { return link->request(n, time, true); }));
    ASSERT_TRUE(rig.until({link.get()}, [&] { return link->newest() && link->newest()->reply.number == n; }));
    ASSERT_TRUE(link->newest_shape());
    EXPECT_EQ(link->newest_shape()->time, time);
  }
}

TEST(ZmqEngine, AClientThatFloodsAndNeverListensCostsTheOthersNothing) {
  ZmqRig rig;
  auto server = rig.serve();
  auto link = rig.connect();
  const std::string request = encode(ClientMessage(StateRequest{1, {seconds(1)}}));
  std::jthread flood([&](const std::stop_token& stop) {
    ClientThatNeverListens flooder(rig);
    while (!stop.stop_requested())
      if (!flooder.send(request)) std::this_thread::yield();
  });
  for (std::uint64_t n = 1; n <= 100; ++n) {
    ASSERT_TRUE(rig.until({link.get()}, [&] { return link->request(n, {seconds(static_cast<double>(n))}); }));
    ASSERT_TRUE(rig.until({link.get()}, [&] { return link->newest() && link->newest()->reply.number == n; }));
  }
  // Its queue of answers is full: they are dropped and counted, and nothing piles up.
  EXPECT_TRUE(rig.until({link.get()}, [&] { return (*server)->counters().unsent > 0; }));
  flood.request_stop();
  flood.join();
  EXPECT_EQ(link->counters().lost, 0u);
  EXPECT_EQ(link->counters().rejected, 0u);
}

TEST(ZmqEngine, ArrivalsAreStampedWhenTheyComeNotWhenTheyAreTaken) {
  ZmqRig rig;
  auto server = rig.serve();
  auto link = rig.connect();
  ASSERT_TRUE(rig.until({link.get()}, [&] { return link->peer_alive(); }));
  ASSERT_TRUE(link->send_sync());
  ASSERT_TRUE(rig.until({}, [&] { return (*server)->counters().syncs >= 1; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(800));  // a busy graphics loop
  const Instant<GraphicsClock> looked = rig.graphics_clock.now();
  link->poll();
  const auto stamps = link->take_sync();
  ASSERT_TRUE(stamps.has_value());
  EXPECT_GT(looked - stamps->t4, std::chrono::milliseconds(100));
}

TEST(ZmqEngine, AClockQuestionIsFollowedUpByTheWireWithoutTheLoop) {
  ZmqRig rig;
  auto server = rig.serve();
  auto link = rig.connect();
  ASSERT_TRUE(rig.until({link.get()}, [&] { return link->peer_alive(); }));
  for (std::uint64_t train = 1; train <= 2; ++train) {
    ASSERT_TRUE(link->send_sync());
    // Nobody polls the link meanwhile.
    ASSERT_TRUE(rig.until({}, [&] { return (*server)->counters().syncs == train * LinkWire::kSyncTrain; }));
    std::vector<SyncStamps> all;
    ASSERT_TRUE(rig.until({link.get()}, [&] {
      while (const auto stamps = link->take_sync()) all.push_back(*stamps);
      return all.size() == LinkWire::kSyncTrain;
    }));
    for (std::size_t i = 0; i < all.size(); ++i) {
      EXPECT_LE(all[i].t2, all[i].t3);
      EXPECT_LE(all[i].t3 - all[i].t2, all[i].t4 - all[i].t1);
      // The next leaves only when the answer before it has come.
      if (i > 0) {
        EXPECT_LE(all[i - 1].t4, all[i].t1);
        EXPECT_LE(all[i - 1].t3, all[i].t2);
      }
    }
  }
  for (int i = 0; i < 50; ++i) rig.wait_a_little();
  EXPECT_EQ((*server)->counters().syncs, 2 * LinkWire::kSyncTrain);
}

// Shows the machine's clock with an offset that may change.
class SteppedClock : public Clock<PhysicsClock> {
 public:
  Instant<PhysicsClock> now() const override { return clock_.now() + Duration(offset_ns_.load()); }
  void sleep_until(Instant<PhysicsClock>) override {}
  void step(Duration by) { offset_ns_ += by.count(); }

 private:
  MonotonicClock<PhysicsClock> clock_;
  std::atomic<std::int64_t> offset_ns_{0};
};

TEST(ZmqEngine, AStepOfTheServersClockIsNoticedWithinTwoTrains) {
  ZmqRig rig;
  SteppedClock physics_clock;
  auto server = serve_states(rig.endpoint, physics_clock, state_at, table_scene());
  ASSERT_TRUE(server);
  auto link = rig.connect();
  ASSERT_TRUE(rig.until({link.get()}, [&] { return link->peer_alive(); }));
  ClockSync<GraphicsClock, PhysicsClock> sync;
  Instant<PhysicsClock> before{};
  const auto train = [&] {
    const int begun = sync.exchanges();
    EXPECT_TRUE(link->send_sync());
    EXPECT_TRUE(rig.until({link.get()}, [&] {
      while (const auto s = link->take_sync()) sync.add(s->t1, s->t2, s->t3, s->t4);
      return sync.exchanges() == begun + static_cast<int>(LinkWire::kSyncTrain);
    }));
    const auto now = sync.remote_time(rig.graphics_clock.now());
    EXPECT_GE(now, before);
    before = now;
  };
  for (const double step_s : {0.0, -0.5, 0.5, 3600.0}) {
    const int restarts = sync.restarts();
    physics_clock.step(seconds(step_s));
    train();
    train();
    EXPECT_EQ(sync.restarts(), restarts + (step_s == 0.0 ? 0 : 1)) << step_s;
    const auto earliest = physics_clock.now();
    const auto here = rig.graphics_clock.now();
    const auto latest = physics_clock.now();
    const Duration stated = sync.model().uncertainty(here);
    EXPECT_GE(sync.model().to(here), earliest - stated) << step_s;
    EXPECT_LE(sync.model().to(here), latest + stated) << step_s;
  }
}

TEST(ZmqEngine, TheServersThreadNeverHoldsUpTheLoopsBesideIt) {
  // Behind the service a loop writes the state the source reads, as the physics loop does; under the thread
  // sanitizer this is where a shared access without order would show.
  ZmqRig rig;
  std::atomic<std::int64_t> tick{0};
  auto server = serve_states(
      rig.endpoint, rig.physics_clock,
      [&](Instant<PhysicsClock> time) {
        scene::StateAnswer answer = state_at(time);
        answer.state.tick = static_cast<std::uint64_t>(tick.load());
        return answer;
      },
      table_scene());
  ASSERT_TRUE(server);
  std::atomic<bool> stop{false};
  std::atomic<int> controls{0};
  std::thread loop([&] {
    while (!stop) {
      ++tick;
      while ((*server)->take_control()) ++controls;
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  });
  auto link = rig.connect();
  ASSERT_TRUE(rig.until({link.get()}, [&] { return link->peer_alive(); }));
  for (std::uint64_t n = 1; n <= 200; ++n) {
    // A machine that stood still may have filled the queue: then a little later.
    ASSERT_TRUE(rig.until({link.get()}, [&] { return link->request(n, {seconds(static_cast<double>(n))}); }));
    if (n % 20 == 0) {
      ASSERT_TRUE(rig.until({link.get()}, [&] { return link->send_control(scene::Control::begin); }));
    }
    ASSERT_TRUE(rig.until({link.get()}, [&] { return link->send_sync(); }));
    rig.wait_a_little();
    link->poll();
    link->frame_drawn(n);
  }
  EXPECT_TRUE(rig.until({link.get()}, [&] { return link->counters().replies == 200 && controls == 10; }));
  stop = true;
  loop.join();
  EXPECT_EQ((*server)->counters().requests, 200u);
  EXPECT_GE((*server)->counters().syncs, 200u);
}

}  // namespace
}  // namespace palpate::transport
