// Server and client over real sockets of this machine, and our client against a device that says what it is told to. Nothing
// here measures time: waits are for what must come, however long a busy machine takes.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "drivers/ndi/driver.h"
#include "drivers/ndi/protocol.h"
#include "drivers/ndi/reply_stream.h"
#include "drivers/network/socket.h"
#include "palpate/core/file.h"
#include "tests/comes_true.h"
#include "tests/scratch_folder.h"

namespace palpate::drivers::ndi {
namespace {

using tests::comes_true;
using Stamp = Instant<TrackerClock>;

network::RigidPose somewhere(int i) {
  return {so3_exp(Vector3(0.1, 0.01 * i, 0.2)), Vector3(0.1 * i, -0.2, 1.0)};
}

std::unique_ptr<network::PoseServer> server_at(std::uint16_t port, const ServerOptions& options) {
  auto server = listen({"127.0.0.1", port}, options);
  EXPECT_TRUE(server.has_value()) << server.error().message;
  return server ? std::move(*server) : nullptr;
}

std::unique_ptr<network::PoseClient> client_of(const network::Address& address,
                                               const ClientOptions& options = {}) {
  auto client = connect(address, options);
  EXPECT_TRUE(client.has_value()) << client.error().message;
  return client ? std::move(*client) : nullptr;
}

// Publishes until the client has heard a pose: it has to be introduced first.
void meet(network::PoseServer& server, network::PoseClient& client, const std::string& tool) {
  int times = 0;
  bool heard = false;
  ASSERT_TRUE(comes_true([&] {
    EXPECT_TRUE(server.publish(tool, Stamp{Duration(++times)}, somewhere(0)).has_value());
    for (const auto& sample : client.poll()) heard = heard || sample.seen;
    return heard;
  })) << client.state().trouble;
  ASSERT_TRUE(server.drain(std::chrono::minutes(2)));
}

std::vector<network::ToolSample> seen_of(network::PoseClient& client, const std::string& tool,
                                         std::size_t count, std::int64_t since_ns) {
  std::vector<network::ToolSample> heard;
  EXPECT_TRUE(comes_true([&] {
    for (auto& sample : client.poll())
      if (sample.seen && sample.tool == tool && sample.stamp.ns() >= since_ns) heard.push_back(sample);
    return heard.size() >= count;
  })) << client.state().trouble;
  return heard;
}

TEST(Loopback, PosesOfSeveralToolsComeWithTheirStamps) {
  const auto server = server_at(0, {.tools = {"Stylus", "Head"}});
  ASSERT_NE(server, nullptr);
  const auto client = client_of(server->address());
  meet(*server, *client, "Stylus");
  for (int i = 0; i < 20; ++i)
    for (const char* tool : {"Stylus", "Head"})
      ASSERT_TRUE(server->publish(tool, Stamp{Duration(1'000'000'000 + 7 * i)}, somewhere(i)).has_value());
  std::map<std::string, std::vector<network::ToolSample>> heard;
  ASSERT_TRUE(comes_true([&] {
    for (auto& sample : client->poll())
      if (sample.stamp.ns() >= 1'000'000'000 && sample.seen) heard[sample.tool].push_back(sample);
    return heard["Stylus"].size() == 20 && heard["Head"].size() == 20;
  }));
  for (const auto& [tool, samples] : heard)
    for (int i = 0; i < 20; ++i) {
      const auto& sample = samples[static_cast<std::size_t>(i)];
      EXPECT_EQ(sample.stamp.ns(), 1'000'000'000 + 7 * i);
      EXPECT_TRUE(sample.server_time);
      // float32: 2^-24 of two metres.
      EXPECT_LT((sample.pose.translation - somewhere(i).translation).norm(), 2e-7);
      EXPECT_LT(sample.pose.rotation.angularDistance(somewhere(i).rotation), 1e-6);
    }
  const auto messages = client->state().messages;
  EXPECT_EQ(messages.refused + messages.damaged + messages.skipped, 0u);
}

TEST(Loopback, AnOlderDeviceGivesTimesOfArrival) {
  const auto server = server_at(0, {.tools = {"Stylus"}, .timestamps = false});
  const auto client = client_of(server->address());
  meet(*server, *client, "Stylus");
  ASSERT_TRUE(server->publish("Stylus", Stamp{Duration(5)}, somewhere(7)).has_value());
  std::vector<network::ToolSample> heard;
  ASSERT_TRUE(comes_true([&] {
    for (auto& sample : client->poll()) heard.push_back(sample);
    return !heard.empty() && std::abs(heard.back().pose.translation.x() - 0.7) < 1e-6;
  }));
  EXPECT_FALSE(heard.back().server_time);
  EXPECT_EQ(heard.back().stamp.ns(), heard.back().arrived_ns);
  // Asked a thousand times a second, it says the same frame again and again: that is no new pose.
  ASSERT_TRUE(comes_true([&] {
    for (const auto& sample : client->poll())
      if (!sample.seen) return true;
    return false;
  })) << "a tool that is published no more is out of sight";
}

TEST(Loopback, AToolThatIsPublishedNoMoreIsOutOfSightOnce) {
  const auto server = server_at(0, {.tools = {"Stylus", "Head"}});
  const auto client = client_of(server->address());
  meet(*server, *client, "Head");
  int unseen = 0;
  ASSERT_TRUE(comes_true([&] {
    for (const auto& sample : client->poll()) unseen += !sample.seen && sample.tool == "Head";
    return unseen > 0;
  }));
  ASSERT_TRUE(server->publish("Stylus", Stamp::from_seconds(9.0), somewhere(1)).has_value());
  const auto after = seen_of(*client, "Stylus", 1, Stamp::from_seconds(9.0).ns());
  EXPECT_EQ(unseen, 1);
}

TEST(Loopback, TheClientComesBackByItself) {
  auto server = server_at(0, {.tools = {"Stylus"}});
  const auto address = server->address();
  const auto client = client_of(address);
  meet(*server, *client, "Stylus");
  server.reset();
  ASSERT_TRUE(comes_true([&] { return !client->state().connected; }));
  client->poll();
  server = server_at(address.port, {.tools = {"Stylus"}});
  meet(*server, *client, "Stylus");
  EXPECT_EQ(client->state().connections, 2u);
}

std::string definition_of(const std::string& part_number) {
  std::string bytes = std::string("NDI") + std::string(0x250 - 3, '\0') + part_number;
  bytes.resize(752, '\0');
  return bytes;
}

TEST(Loopback, AWirelessToolIsTheOneOfItsDefinition) {
  const auto server = server_at(0, {.tools = {"Wired", "8700339"}});
  const auto client =
      client_of(server->address(),
                {.wireless = {{"probe", definition_of("8700339")}, {"nobody", definition_of("1234567")}}});
  meet(*server, *client, "8700339");
  ASSERT_TRUE(server->publish("8700339", Stamp::from_seconds(5.0), somewhere(3)).has_value());
  const auto heard = seen_of(*client, "probe", 1, Stamp::from_seconds(5.0).ns());
  EXPECT_LT((heard.back().pose.translation - somewhere(3).translation).norm(), 2e-7);
}

TEST(Loopback, ToolsOfTheSameNameAreToldApart) {
  const std::string twenty = "TwentyLettersAreAll_";
  const auto server = server_at(0, {.tools = {twenty + "A", twenty + "B"}});
  const auto client = client_of(server->address());
  meet(*server, *client, twenty + "A");
  ASSERT_TRUE(server->publish(twenty + "B", Stamp::from_seconds(5.0), somewhere(3)).has_value());
  seen_of(*client, twenty + ":2", 1, Stamp::from_seconds(5.0).ns());
}

TEST(Loopback, WhatHasNoPlaceInTheProtocolIsRefused) {
  const auto server = server_at(0, {});
  EXPECT_FALSE(server->publish("", {}, somewhere(1)));
  EXPECT_FALSE(server->publish(std::string(200, 'x'), {}, somewhere(1)));
  EXPECT_FALSE(server->publish("two\nlines", {}, somewhere(1)));
  EXPECT_FALSE(server->publish("a", Stamp{Duration(-5)}, somewhere(1)));
  EXPECT_FALSE(server->publish("a", Stamp::from_seconds(5e9), somewhere(1)));
  EXPECT_FALSE(server->publish("a", {}, {Quaternion::Identity(), Vector3(std::nan(""), 0, 0)}));
  EXPECT_FALSE(server->publish("a", {}, {Quaternion(2, 0, 0, 0), Vector3::Zero()}));
  for (std::size_t i = 0; i < kMostServed; ++i)
    EXPECT_TRUE(server->publish(fmt::format("tool {}", i), {}, somewhere(1)).has_value());
  EXPECT_FALSE(server->publish("one more", {}, somewhere(1)));
  EXPECT_FALSE(listen({"127.0.0.1", 0}, {.tools = {"good", ""}}).has_value());
  const auto second = listen(server->address());
  ASSERT_FALSE(second.has_value());
  EXPECT_NE(second.error().message.find("choose another port"), std::string::npos);
}

// Speaks to a socket as a client or as a device would.
class Peer {
 public:
  explicit Peer(FileDescriptor socket) : socket_(std::move(socket)) {}

  void say(const std::string& bytes) {
    EXPECT_EQ(::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  // All up to `end`; empty where the other side closes.
  std::string until(char end) {
    std::string heard;
    while (heard.empty() || heard.back() != end) {
      pollfd item{socket_.get(), POLLIN, 0};
      EXPECT_EQ(::poll(&item, 1, 60'000), 1);
      char byte = 0;
      if (::recv(socket_.get(), &byte, 1, 0) != 1) return "";
      heard += byte;
    }
    return heard;
  }

 private:
  FileDescriptor socket_;
};

Peer peer_of(const network::PoseServer& server) {
  auto socket = network::begin_connect(network::resolve(server.address())->front());
  pollfd item{socket.get(), POLLOUT, 0};
  EXPECT_EQ(::poll(&item, 1, 60'000), 1);
  return Peer(std::move(socket));
}

TEST(Loopback, TheServerAnswersWithTheCodesOfTheApi) {
  const auto server = server_at(0, {.tools = {"Stylus"}});
  auto peer = peer_of(*server);
  const auto answer = [&](const std::string& command) {
    peer.say(command);
    const auto reply = peer.until('\r');
    return reply.size() > 5 ? reply.substr(0, reply.size() - 5) : reply;
  };
  const auto say = [&](const std::string& words) { return answer(encode_command(words)); };
  EXPECT_EQ(say("PHSR:02"), "ERROR10") << "not initialized";
  EXPECT_EQ(answer("INIT:0000\r"), "ERROR04") << "checksum";
  EXPECT_EQ(answer("INIT:\r"), "ERROR03");
  EXPECT_EQ(say("WHAT:"), "ERROR01");
  EXPECT_EQ(answer("nothing\r"), "ERROR01");
  EXPECT_EQ(say("INIT:"), "OKAY");
  EXPECT_EQ(say("COMM:50000"), "OKAY");
  EXPECT_EQ(say("TX:0001"), "ERROR0C") << "not tracking";
  EXPECT_EQ(say("PHSR:01"), "00");
  EXPECT_EQ(say("PHSR:02"), "0101001");
  EXPECT_EQ(say("PHSR:09"), "ERROR23");
  EXPECT_EQ(say("PENA:01D"), "ERROR0E") << "not initialized";
  EXPECT_EQ(say("PINIT:01"), "OKAY");
  EXPECT_EQ(say("PINIT:07"), "ERROR08");
  EXPECT_EQ(say("PINIT:zz"), "ERROR07");
  EXPECT_EQ(say("PENA:01X"), "ERROR09");
  EXPECT_EQ(say("PENA:01D"), "OKAY");
  EXPECT_EQ(say("PHSR:04"), "0101031");
  EXPECT_EQ(say("PHINF:010004"), "Stylus              ");
  EXPECT_EQ(say("PHRQ:*********1****"), "02");
  EXPECT_EQ(say("PVWR:020000" + std::string(128, '0')), "OKAY");
  EXPECT_EQ(say("PVWR:0207C1" + std::string(128, '0')), "ERROR23");
  EXPECT_EQ(say("PVWR:010000" + std::string(128, '0')), "ERROR08") << "no wireless one";
  EXPECT_EQ(say("PVWR:0200"), "ERROR07");
  EXPECT_EQ(say("PHF:02"), "OKAY");
  EXPECT_EQ(say("TSTART:"), "OKAY");
  EXPECT_EQ(say("TX:0001"), "0101MISSING0000003100000000\n0000");
  EXPECT_EQ(say("TX:0004"), "ERROR23");
  EXPECT_EQ(say("PHSR:02"), "ERROR0C") << "while tracking";
  EXPECT_EQ(answer("TSTOP \r"), "OKAY");
  EXPECT_EQ(say("TSTOP:"), "ERROR0C");
}

TEST(Loopback, WhoSpeaksSomethingElseIsThrownOut) {
  const auto server = server_at(0, {});
  peer_of(*server).say("GET / HTTP/1.1\r\nHost: localhost\r\nAccept: text/html\r\n\r\n");
  EXPECT_TRUE(comes_true([&] { return server->state().thrown_out == 1; }));
  peer_of(*server).say(std::string(5000, 'x'));
  EXPECT_TRUE(comes_true([&] { return server->state().thrown_out == 2; }));
}

// A device of which a test says what it answers; what it has no answer for is OKAY.
class Device {
 public:
  using Answers = std::map<std::string, std::string>;  // by the command's name; whole replies

  Device() : listening_(*network::listen_at({"127.0.0.1", 0})) {}
  const network::Address& address() const { return listening_.address; }

  // One connection, until the client closes it or `enough` commands have come. The commands, without checksums.
  std::vector<std::string> serve(const Answers& answers, std::size_t enough) {
    pollfd item{listening_.socket.get(), POLLIN, 0};
    EXPECT_EQ(::poll(&item, 1, 60'000), 1);
    peer_ = std::make_unique<Peer>(network::accept_from(listening_.socket));
    std::vector<std::string> commands;
    while (commands.size() < enough) {
      const auto line = peer_->until('\r');
      if (line.empty()) break;
      commands.push_back(line.substr(0, line.size() - 5));
      const auto known = answers.find(commands.back().substr(0, commands.back().find(':')));
      peer_->say(known == answers.end() ? encode_text("OKAY") : known->second);
    }
    return commands;
  }

 private:
  network::Listening listening_;
  std::unique_ptr<Peer> peer_;
};

TEST(Conversation, ItAsksInTheOrderOfTheApi) {
  Device device;
  const auto client = client_of(device.address(), {.wireless = {{"probe", std::string(70, '\x5a')}}});
  const Reading reading{
      .handle = 10, .state = Reading::State::valid, .pose = somewhere(1), .status = 0x31, .frame = 5};
  const auto commands = device.serve({{"PHSR", encode_text("010A001")},
                                      {"PHRQ", encode_text("0A")},
                                      {"PHINF", encode_text("UNOCCUPIED")},
                                      {"BX2", encode_error(Code::unknown_command)},
                                      {"BX", encode_binary(encode_bx({reading}))}},
                                     16);
  std::string whole_block;
  for (int i = 0; i < 64; ++i) whole_block += "5A";
  const std::vector<std::string> expected{"INIT:",
                                          "PHSR:01",
                                          "PHF:0A",
                                          "PHRQ:*********1****",
                                          "PVWR:0A0000" + whole_block,
                                          "PVWR:0A00405A5A5A5A5A5A" + std::string(116, '0'),
                                          "PHSR:02",
                                          "PINIT:0A",
                                          "PHSR:03",
                                          "PENA:0AD",
                                          "PHINF:0A0005",
                                          "TSTART:",
                                          "BX2:--6d=tools",
                                          "BX:0001",
                                          "BX:0001",
                                          "BX:0001"};
  EXPECT_EQ(commands, expected);
  ASSERT_TRUE(comes_true([&] { return client->state().samples == 1; })) << "the same frame is one pose";
  EXPECT_EQ(client->poll().front().tool, "probe");
}

TEST(Conversation, WhatGoesWrongIsToldInWordsAndTriedAgain) {
  Device device;
  const auto client = client_of(device.address());
  const auto trouble_after = [&](const Device::Answers& answers) {
    device.serve(answers, 100);
    EXPECT_TRUE(comes_true([&] { return !client->state().trouble.empty(); }));
    return client->state().trouble;
  };
  EXPECT_EQ(trouble_after({{"INIT", encode_error(static_cast<Code>(0x15))}}),
            "INIT: ERROR15, it cannot initialize itself");
  EXPECT_NE(trouble_after({{"INIT", "HTTP/1.1 400 Bad Request\r"}}).find("'HTTP/1.1 400 Bad Request'"),
            std::string::npos);
  EXPECT_NE(trouble_after({{"INIT", std::string(100, '\x01')}}).find("begins with the byte 01"),
            std::string::npos);
  EXPECT_NE(trouble_after({{"PHSR", encode_text("05")}}).find("a list of handles '05'"), std::string::npos);
  EXPECT_NE(trouble_after({{"PHSR", encode_text("00") + encode_text("RESET")}}).find("'RESET'"),
            std::string::npos);
}

TEST(Conversation, ADeviceThatDoesNotReplyIsLeftAndTriedAgain) {
  Device device;
  const auto client = client_of(device.address());
  EXPECT_EQ(device.serve({{"PHSR", ""}}, 100).back(), "PHSR:01");
  EXPECT_TRUE(comes_true([&] { return !client->state().trouble.empty(); }));
  EXPECT_EQ(client->state().trouble, "no reply to PHSR:01 within 2 s; one is expected");
  EXPECT_EQ(device.serve({}, 1).front(), "INIT:");
}

TEST(Conversation, AnotherProgramsTrackingIsStoppedFirst) {
  Device device;
  const auto client = client_of(device.address());
  EXPECT_EQ(device.serve({{"INIT", encode_error(Code::not_in_this_mode)}}, 100),
            (std::vector<std::string>{"INIT:", "TSTOP:", "INIT:"}));
}

TEST(Conversation, AToolThatCannotBeInitializedLeavesTheOthers) {
  Device device;
  const auto client = client_of(device.address());
  // What is not enabled has no name, and poses of it are passed over.
  const Reading known{
      .handle = 1, .state = Reading::State::valid, .pose = somewhere(1), .status = 0, .frame = 5};
  Reading stranger = known;
  stranger.handle = 9;
  Reading outside = known;
  outside.handle = 2;
  outside.status = kFrameOutOfVolume;
  const auto frame = [&](std::uint32_t number) {
    return Frame{Stamp::from_seconds(number), number, {known, outside, stranger}};
  };
  device.serve({{"PHSR", encode_text("0201001"
                                     "02001")},
                {"PHINF", encode_text(encode_tool_info({"00000000", "Probe", 0x31}))},
                {"BX2", encode_binary(encode_bx2({frame(5)}))},
                {"PHF", encode_error(Code::no_such_handle)}},
               20);
  ASSERT_TRUE(comes_true([&] { return client->state().samples == 2; }));
  const auto heard = client->poll();
  EXPECT_EQ(heard[0].tool, "Probe");
  EXPECT_TRUE(heard[0].seen);
  EXPECT_EQ(heard[0].stamp, Stamp::from_seconds(5));
  EXPECT_EQ(heard[1].tool, "Probe:2");
  EXPECT_FALSE(heard[1].seen);
  EXPECT_GE(client->state().messages.skipped, 1u);
  EXPECT_NE(client->state().trouble.find("PHF:02: ERROR08"), std::string::npos) << client->state().trouble;
}

TEST(Conversation, DamagedPosesAreCountedAndAskedForAgain) {
  Device device;
  const auto client = client_of(device.address());
  auto damaged = encode_binary(encode_bx2({}));
  damaged.back() ^= 1;
  device.serve({{"PHSR", encode_text("0101001")},
                {"PHINF", encode_text(encode_tool_info({"0000002A", "", 0x31}))},
                {"BX2", damaged}},
               15);
  ASSERT_TRUE(comes_true([&] { return client->state().messages.damaged > 1; }));
}

TEST(Driver, ItsMarkersAreToolsByTheirFiles) {
  device::DriverRegistry drivers;
  add_to(drivers);
  const ScratchFolder folder;
  const auto file = folder / "8700339.rom";
  ASSERT_TRUE(write_file(file, definition_of("8700339")));
  const auto server = server_at(0, {.tools = {"8700339"}});
  const std::string at = "ndi://" + server->address().text();
  const device::TrackerRequest request{at + "/" + file.string(), {"camera_marker=" + file.stem().string()}};
  EXPECT_TRUE(drivers.check(request).has_value());
  for (const auto* bad : {"ndi://", "ndi://host:port", "ndi://host/no such file.rom", "ndi://host/a,"})
    EXPECT_EQ(drivers.check(device::TrackerRequest{bad, {}}).error().exit_code(), 2) << bad;
  auto opened = drivers.open(request);
  ASSERT_TRUE(opened.has_value()) << opened.error().message;
  int i = 0;
  std::vector<device::TrackerSample> samples;
  EXPECT_TRUE(comes_true([&] {
    EXPECT_TRUE(server->publish("8700339", Stamp{Duration(++i)}, somewhere(3)).has_value());
    for (const auto& sample : (*opened)->device().poll())
      if (sample.seen) samples.push_back(sample);
    return !samples.empty();
  })) << (*opened)->why_unheard();
  EXPECT_EQ(samples.front().marker, device::MarkerId::camera_marker);
  EXPECT_LT((samples.front().translation - somewhere(3).translation).norm(), 2e-7);
}

TEST(Address, OfATrackerNamesFilesToo) {
  const auto plain = split_place("host:1234");
  EXPECT_EQ(plain.server, "host:1234");
  EXPECT_TRUE(plain.files.empty());
  EXPECT_TRUE(split_place("host/").files.empty());
  const auto files = split_place("host/probe.rom,tools/head.rom,/a/b.rom");
  EXPECT_EQ(files.server, "host");
  EXPECT_EQ(files.files, (std::vector<std::string>{"probe.rom", "tools/head.rom", "/a/b.rom"}));
  for (const char* bad : {"", "there is no such file.rom"}) {
    const auto read = read_definitions({bad});
    ASSERT_FALSE(read.has_value()) << bad;
    EXPECT_EQ(read.error().exit_code(), 2) << bad;
  }
}

}  // namespace
}  // namespace palpate::drivers::ndi
