// Publisher and driver over real sockets of this machine. Nothing here measures time: waits are for what must
// come, however long a busy machine takes.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <chrono>
#include <thread>

#include "drivers/network/marker_tracker.h"
#include "drivers/network/recording.h"
#include "drivers/network/socket.h"
#include "drivers/openigtlink/loopback_for_tests.h"
#include "drivers/openigtlink/message_stream.h"

namespace palpate::drivers::openigtlink {
namespace {

using Stamp = Instant<TrackerClock>;

RigidPose somewhere(int i) { return {so3_exp(Vector3(0.1, 0.01 * i, 0.2)), Vector3(0.1 * i, -0.2, 1.0)}; }

// A plain socket, for peers that misbehave.
FileDescriptor connect_to(const network::Address& address, int buffer = 0) {
  FileDescriptor socket = network::begin_connect(network::resolve(address)->front());
  pollfd item{socket.get(), POLLOUT, 0};
  EXPECT_EQ(::poll(&item, 1, 60'000), 1);
  EXPECT_TRUE(network::connected(socket));
  if (buffer > 0) {
    EXPECT_EQ(::setsockopt(socket.get(), SOL_SOCKET, SO_RCVBUF, &buffer, sizeof buffer), 0);
  }
  return socket;
}

void send_all(const FileDescriptor& socket, const std::string& bytes) {
  EXPECT_EQ(::send(socket.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(bytes.size()));
}

FileDescriptor accept_one(const network::Listening& server) {
  pollfd item{server.socket.get(), POLLIN, 0};
  EXPECT_EQ(::poll(&item, 1, 60'000), 1);
  return network::accept_from(server.socket);
}

TEST(Loopback, EveryClientGetsEveryPose) {
  const auto server = server_at();
  ASSERT_NE(server, nullptr);
  std::vector<std::unique_ptr<network::PoseClient>> clients;
  for (int i = 0; i < 3; ++i) clients.push_back(client_of(server->address()));
  ASSERT_TRUE(comes_true([&] { return server->state().clients == 3; }));
  for (int i = 0; i < 20; ++i)
    ASSERT_TRUE(server->publish("StylusToTracker", Stamp::from_seconds(1.0 + i), somewhere(i)).has_value());
  for (const auto& client : clients) {
    ASSERT_TRUE(comes_true([&] { return client->state().samples == 20; }));
    const auto samples = client->poll();
    ASSERT_EQ(samples.size(), 20u);
    for (int i = 0; i < 20; ++i) {
      const auto& sample = samples[static_cast<std::size_t>(i)];
      EXPECT_EQ(sample.tool, "StylusToTracker");
      EXPECT_EQ(sample.stamp, Stamp::from_seconds(1.0 + i));
      EXPECT_TRUE(sample.server_time && sample.seen);
      EXPECT_LT((sample.pose.translation - somewhere(i).translation).norm(), 1e-6);  // float32
    }
    EXPECT_TRUE(client->poll().empty());
    EXPECT_EQ(client->state().messages.damaged + client->state().messages.refused + client->state().lost, 0u);
  }
  EXPECT_TRUE(server->drain(std::chrono::minutes(2)));
  EXPECT_EQ(server->state().sent, 60u);
}

TEST(Loopback, WithoutAStampOfTheServerTheArrivalCounts) {
  const auto server = server_at();
  const auto client = client_of(server->address());
  ASSERT_TRUE(comes_true([&] { return server->state().clients == 1; }));
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(server->publish("a", std::nullopt, somewhere(0)).has_value());
  ASSERT_TRUE(comes_true([&] { return client->state().samples == 2; })) << "unstamped ones are never repeats";
  for (const auto& sample : client->poll()) {
    EXPECT_FALSE(sample.server_time);
    EXPECT_EQ(sample.stamp.ns(), sample.arrived_ns);
  }
}

TEST(Loopback, APoseSentAgainIsNoNewMeasurement) {
  const auto server = server_at();
  const auto client = client_of(server->address());
  ASSERT_TRUE(comes_true([&] { return server->state().clients == 1; }));
  for (const int i : {1, 1, 1, 2})
    ASSERT_TRUE(server->publish("a", Stamp::from_seconds(i), somewhere(i)).has_value());
  ASSERT_TRUE(comes_true([&] { return client->state().samples == 2; }));
  EXPECT_EQ(client->state().repeats, 2u);
}

TEST(Loopback, TheClientComesBackByItself) {
  auto server = server_at();
  const network::Address address = server->address();
  const auto client = client_of(address);
  ASSERT_TRUE(comes_true([&] { return server->state().clients == 1 && client->state().connected; }));
  server.reset();
  ASSERT_TRUE(comes_true([&] { return !client->state().connected; }));
  EXPECT_NE(client->state().trouble, "");
  server = server_at(address.port);
  ASSERT_TRUE(comes_true([&] { return server->state().clients == 1; }));
  ASSERT_TRUE(server->publish("a", {}, somewhere(1)).has_value());
  ASSERT_TRUE(comes_true([&] { return client->state().samples == 1; }));
  EXPECT_EQ(client->state().connections, 2u);
}

TEST(Loopback, AStalledClientHoldsUpNobody) {
  const auto server = server_at(0, {.of_any = {.most_waiting = 64, .stalled_after = Duration(0)}});
  const auto stalled = connect_to(server->address());
  const auto client = client_of(server->address());
  ASSERT_TRUE(comes_true([&] { return server->state().clients == 2; }));
  // Until the stalled one's queue overflows; what buffers of the kernel take before that is the system's
  // choice.
  int sent = 0;
  while (server->state().dropped == 0 && sent < 1'000'000) {
    for (int i = 0; i < 32; ++i)
      ASSERT_TRUE(server->publish("a", Stamp::from_seconds(++sent), somewhere(i)).has_value());
    ASSERT_TRUE(comes_true([&] {
      const auto samples = client->poll();
      return client->state().samples >= static_cast<std::uint64_t>(sent);
    })) << "the other client gets all";
  }
  EXPECT_GT(server->state().dropped, 0u);
  // The stalled one wakes up and finds whole messages, the newest among them.
  MessageStream stream;
  std::optional<Stamp> newest;
  char buffer[16 * 1024];
  EXPECT_TRUE(comes_true([&] {
    for (ssize_t count = 1; count > 0;) {
      count = ::recv(stalled.get(), buffer, sizeof buffer, 0);
      if (count > 0)
        stream.take({buffer, static_cast<std::size_t>(count)}, [&](Message&& m) { newest = m.stamp; });
    }
    return newest == Stamp::from_seconds(sent);
  }));
  EXPECT_EQ(stream.counts().bad_crc + stream.counts().refused, 0u);
}

TEST(Loopback, AClientThatTakesNothingForLongIsDisconnected) {
  const auto server =
      server_at(0, {.of_any = {.most_waiting = 64, .stalled_after = std::chrono::milliseconds(50)}});
  const auto stalled = connect_to(server->address());
  const auto client = client_of(server->address());
  ASSERT_TRUE(comes_true([&] { return server->state().clients == 2; }));
  int sent = 0;
  EXPECT_TRUE(comes_true([&] {
    for (int i = 0; i < 100; ++i)
      EXPECT_TRUE(server->publish("a", Stamp::from_seconds(++sent), somewhere(i)).has_value());
    return server->state().stalled >= 1;
  }));
  pollfd item{stalled.get(), 0, 0};
  EXPECT_EQ(::poll(&item, 1, 60'000), 1) << "its end is told at once";
}

// All places are taken by clients that never read: what they leave lying is in the system's buffers, and the
// queues here may stay empty.
TEST(Loopback, ClientsThatNeverReadKeepNoPlaces) {
  const auto server = server_at();
  std::vector<FileDescriptor> silent;
  for (std::size_t i = 0; i < network::PoseServerOptions{}.most_clients; ++i) {
    silent.push_back(connect_to(server->address(), 2048));
    ASSERT_TRUE(comes_true([&] { return server->state().clients == silent.size(); }));
  }
  const auto client = client_of(server->address());  // comes again where it is turned away
  const auto begun = std::chrono::steady_clock::now();
  int sent = 0;
  EXPECT_TRUE(comes_true([&] {
    for (int i = 0; i < 10; ++i)
      EXPECT_TRUE(server->publish("a", Stamp::from_seconds(++sent), somewhere(i)).has_value());
    client->poll();
    // Its place is free with the first of them that has to go; the others follow, each when its time is up.
    return client->state().samples > 0 && server->state().stalled == silent.size();
  }));
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(60));
  EXPECT_GE(server->state().turned_away, 1u);
}

TEST(Loopback, AClientThatHasNothingToReadKeepsItsPlace) {
  const auto server = server_at(0, {.of_any = {.stalled_after = std::chrono::milliseconds(20)}});
  const auto idle = connect_to(server->address());
  const auto client = client_of(server->address());
  ASSERT_TRUE(comes_true([&] { return server->state().clients == 2; }));
  int looks = 0;
  EXPECT_TRUE(comes_true([&] { return ++looks == 30; }));  // of 10 ms
  EXPECT_EQ(server->state().clients, 2u);
}

// A client that reads everything, and publishes poses of tools a and b until something has come of it.
struct Asker {
  network::PoseServer& server;
  FileDescriptor socket;
  MessageStream stream;
  int sent = 0, transforms = 0, other = 0;
  std::vector<Message> data;

  void read() {
    pollfd item{socket.get(), POLLIN, 0};
    while (::poll(&item, 1, 0) == 1) {
      char buffer[16 * 1024];
      const ssize_t count = ::recv(socket.get(), buffer, sizeof buffer, 0);
      if (count <= 0) return;
      stream.take({buffer, static_cast<std::size_t>(count)}, [this](Message&& message) {
        if (std::holds_alternative<Transform>(message.content))
          ++transforms;
        else if (std::holds_alternative<TrackingData>(message.content))
          data.push_back(std::move(message));
        else
          ++other;
      });
    }
  }
  bool until(const std::function<bool()>& condition) {
    return comes_true([&] {
      ++sent;
      EXPECT_TRUE(server.publish("a", Stamp::from_seconds(sent), somewhere(1)).has_value());
      EXPECT_TRUE(server.publish("b", Stamp::from_seconds(sent + 0.5), somewhere(2)).has_value());
      read();
      return condition();
    });
  }
};

TEST(Loopback, TrackingDataComesToWhoAsksForItAndTransformsAgainWhenItHasEnough) {
  const auto server = server_at(0, {.tracking_data = true});
  Asker asker{.server = *server, .socket = connect_to(server->address())};
  ASSERT_TRUE(asker.until([&] { return asker.transforms > 0; }));
  EXPECT_TRUE(asker.data.empty());
  send_all(asker.socket, *encode({"", {}, StartTracking{0, ""}}));
  const auto tools_of = [](const Message& message) { return std::get<TrackingData>(message.content).tools; };
  ASSERT_TRUE(asker.until([&] { return !asker.data.empty() && tools_of(asker.data.back()).size() == 2; }));
  const auto tools = tools_of(asker.data.back());
  EXPECT_EQ(tools[0].name, "a");
  EXPECT_EQ(tools[1].name, "b");
  EXPECT_LT((tools[1].pose.translation - somewhere(2).translation).norm(), 1e-6);  // float32
  EXPECT_TRUE(asker.data.back().stamp.has_value());
  const int before = asker.transforms;
  const auto data_before = asker.data.size();
  ASSERT_TRUE(asker.until([&] { return asker.data.size() > data_before; }));
  EXPECT_EQ(asker.transforms, before) << "one or the other";
  send_all(asker.socket, *encode({"", {}, StopTracking{}}));
  ASSERT_TRUE(asker.until([&] { return asker.transforms > before; }));
  EXPECT_EQ(asker.other, 0);
}

TEST(Loopback, TrackingDataKeepsTheIntervalThatWasAskedFor) {
  const auto server = server_at(0, {.tracking_data = true});
  Asker asker{.server = *server, .socket = connect_to(server->address())};
  const auto begun = std::chrono::steady_clock::now();
  send_all(asker.socket, *encode({"", {}, StartTracking{60, ""}}));
  ASSERT_TRUE(asker.until([&] { return asker.data.size() >= 6; }));
  EXPECT_GE(std::chrono::steady_clock::now() - begun, std::chrono::milliseconds(5 * 60));
}

TEST(Loopback, WhoDoesNotServeTrackingDataSendsTransformsToAll) {
  const auto server = server_at();
  Asker asker{.server = *server, .socket = connect_to(server->address())};
  send_all(asker.socket, *encode({"", {}, StartTracking{0, ""}}));
  ASSERT_TRUE(asker.until([&] { return asker.transforms > 20; }));
  EXPECT_TRUE(asker.data.empty());
}

TEST(Loopback, AClientThatSpeaksSomethingElseIsThrownOut) {
  const auto server = server_at();
  const auto client = client_of(server->address());
  const auto browser = connect_to(server->address());
  ASSERT_TRUE(comes_true([&] { return server->state().clients == 2; }));
  send_all(browser, "GET / HTTP/1.1\r\nHost: localhost\r\nAccept: text/html,application/xhtml+xml\r\n\r\n");
  ASSERT_TRUE(comes_true([&] { return server->state().thrown_out == 1; }));
  EXPECT_EQ(server->state().clients, 1u);
  ASSERT_TRUE(server->publish("a", {}, somewhere(1)).has_value());
  EXPECT_TRUE(comes_true([&] { return client->state().samples == 1; }));
}

TEST(Loopback, ClientsBeyondTheBoundAreTurnedAway) {
  const auto server = server_at(0, {.of_any = {.most_clients = 2}});
  const auto a = connect_to(server->address()), b = connect_to(server->address());
  ASSERT_TRUE(comes_true([&] { return server->state().clients == 2; }));
  const auto c = connect_to(server->address());
  EXPECT_TRUE(comes_true([&] { return server->state().turned_away == 1; }));
  EXPECT_EQ(server->state().clients, 2u);
}

TEST(Loopback, TwoServersDoNotShareAnAddress) {
  const auto server = server_at();
  const auto second = listen(server->address());
  ASSERT_FALSE(second.has_value());
  EXPECT_NE(second.error().message.find("choose another port"), std::string::npos);
}

TEST(Loopback, AServerThatTalksNonsenseIsLeftAndTriedAgain) {
  auto server = network::listen_at({"127.0.0.1", 0});
  ASSERT_TRUE(server.has_value());
  const auto client = client_of(server->address);
  const auto first = accept_one(*server);
  send_all(first, std::string(200, 'x'));
  const auto again = accept_one(*server);
  ASSERT_TRUE(again);
  EXPECT_NE(client->state().trouble.find("not OpenIGTLink"), std::string::npos);
  send_all(again, *encode({"a", {}, Status{13, 0, "Failure", "no camera"}}));
  ASSERT_TRUE(
      comes_true([&] { return client->state().trouble.find("13 Failure no camera") != std::string::npos; }));
  std::string damaged = *encode({"a", {}, Transform{}});
  damaged.back() = 'x';
  send_all(again, damaged + *encode({"b", {}, Transform{}}));
  ASSERT_TRUE(comes_true([&] { return client->state().samples == 1; }));
  EXPECT_EQ(client->state().messages.damaged, 1u);
  EXPECT_EQ(client->poll().front().tool, "b");
}

TEST(Loopback, AServerThatWantsAStartRequestGetsOne) {
  for (const auto start : {StartRequest::when_silent, StartRequest::at_once}) {
    auto server = network::listen_at({"127.0.0.1", 0});
    ASSERT_TRUE(server.has_value());
    auto client = client_of(server->address, {.start = start, .period_ms = 20});
    const auto socket = accept_one(*server);
    MessageStream stream;
    std::vector<Message> heard;
    const auto read = [&] {
      pollfd item{socket.get(), POLLIN, 0};
      EXPECT_EQ(::poll(&item, 1, 120'000), 1);
      char buffer[512];
      const auto count = ::recv(socket.get(), buffer, sizeof buffer, 0);
      if (count > 0)
        stream.take({buffer, static_cast<std::size_t>(count)},
                    [&](Message&& m) { heard.push_back(std::move(m)); });
      return count > 0;
    };
    while (heard.empty()) ASSERT_TRUE(read());
    ASSERT_TRUE(std::holds_alternative<StartTracking>(heard[0].content));
    EXPECT_EQ(std::get<StartTracking>(heard[0].content).resolution_ms, 20);
    send_all(socket, *encode({"Tracker", Stamp::from_seconds(5),
                              TrackingData{{{"one", 2, somewhere(1)}, {"two", 2, somewhere(2)}}}}));
    ASSERT_TRUE(comes_true([&] { return client->state().samples == 2; }));
    const auto samples = client->poll();
    EXPECT_EQ(samples[0].tool, "one");
    EXPECT_EQ(samples[1].tool, "two");
    client.reset();
    while (heard.size() < 2) ASSERT_TRUE(read());
    EXPECT_TRUE(std::holds_alternative<StopTracking>(heard[1].content));
  }
}

TEST(Loopback, EndlessNewNamesAreBounded) {
  const auto server = server_at();
  const auto client = client_of(server->address());
  ASSERT_TRUE(comes_true([&] { return server->state().clients == 1; }));
  for (std::size_t i = 0; i < network::PoseClient::kMostTools + 5; ++i)
    ASSERT_TRUE(server->publish(fmt::format("tool {}", i), {}, somewhere(0)).has_value());
  ASSERT_TRUE(comes_true([&] { return client->state().too_many == 5; }));
  EXPECT_EQ(client->state().samples, network::PoseClient::kMostTools);
}

TEST(Loopback, ToolsBecomeMarkersInWorld) {
  const auto server = server_at();
  network::TrackerMapping mapping{
      .markers = {{"Stylus", device::MarkerId::pointer}, {"Head", device::MarkerId::camera_marker}},
      .X_world_server = {so3_exp(Vector3(0, 0, 1)), Vector3(1, 2, 3)},
      .translation_sd = 0.001};
  network::MarkerTracker tracker(client_of(server->address()), mapping);
  device::TrackerDevice& device = tracker;
  ASSERT_TRUE(comes_true([&] { return server->state().clients == 1; }));
  for (const char* tool : {"Other", "Head", "Stylus"})
    ASSERT_TRUE(server->publish(tool, Stamp::from_seconds(7), somewhere(2)).has_value());
  ASSERT_TRUE(comes_true([&] { return tracker.state().samples == 3; }));
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  const auto samples = device.poll();
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_GE(samples[0].waited, std::chrono::milliseconds(30));
  EXPECT_LT(samples[0].waited, std::chrono::seconds(60));
  EXPECT_EQ(samples[0].marker, device::MarkerId::camera_marker);
  EXPECT_EQ(samples[1].marker, device::MarkerId::pointer);
  EXPECT_EQ(samples[1].stamp, Stamp::from_seconds(7));
  EXPECT_TRUE(samples[1].seen);
  const Vector3 expected = so3_exp(Vector3(0, 0, 1)) * somewhere(2).translation + Vector3(1, 2, 3);
  EXPECT_LT((samples[1].translation - expected).norm(), 1e-6);
  EXPECT_DOUBLE_EQ(samples[1].covariance(3, 3), 1e-6);
}

}  // namespace
}  // namespace palpate::drivers::openigtlink
