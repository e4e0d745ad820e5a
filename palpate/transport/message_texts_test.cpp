// What is wrong with a client's devices, and texts of all kinds, on their way to whoever asks for the status.
#include <gtest/gtest.h>
#include <palpate.pb.h>

#include <cctype>

#include "palpate/transport/messages.h"

namespace palpate::transport {
namespace {

TEST(Messages, EveryConditionTravelsByItsCodeAndAnUnknownOneIsRefused) {
  for (std::size_t i = 0; i < device::kHealthCodes; ++i) {
    const auto code = static_cast<device::HealthCode>(i);
    ClientFigures figures;
    figures.conditions = {{code, 0.5, "words"}};
    const std::string bytes = encode(ClientMessage(Hello{1, 0, "graphics", figures}));
    const auto hello = decode_client_message(bytes);
    ASSERT_TRUE(hello) << hello.error().message;
    EXPECT_EQ(std::get<Hello>(*hello).figures->conditions[0].code, code);
    // By its name, for peers in other languages.
    wire::ToPhysics wire;
    ASSERT_TRUE(wire.ParseFromString(bytes));
    auto& sent = *wire.mutable_hello()->mutable_figures()->mutable_conditions(0);
    std::string name = "HEALTH_CODE_" + std::string(device::name_of(code));
    for (char& c : name) c = static_cast<char>(std::toupper(c));
    EXPECT_EQ(wire::HealthCode_Name(sent.code()), name);
    EXPECT_EQ(sent.severity(), static_cast<int>(device::severity_of(code)) + 1);
    for (const int unknown : {0, static_cast<int>(device::kHealthCodes) + 1, 1'000'000}) {
      sent.set_code(static_cast<wire::HealthCode>(unknown));
      EXPECT_FALSE(decode_client_message(wire.SerializeAsString())) << unknown;
    }
  }
}

TEST(Messages, TheAgeOfATroubleIsNoNews) {
  ClientFigures before;
  before.conditions = {{device::HealthCode::board_lost, 1.0, "board: not found"}};
  ClientFigures now = before;
  now.conditions[0].age_s = 2.0;
  EXPECT_TRUE(same_trouble(before, now));
  now.conditions[0].code = device::HealthCode::landmarks_lost;
  EXPECT_FALSE(same_trouble(before, now));
  now = before;
  now.conditions[0].words = "board: too small";
  EXPECT_FALSE(same_trouble(before, now));
  now.conditions.clear();
  EXPECT_FALSE(same_trouble(before, now));
}

TEST(Messages, AStatusOfAsManyClientsAsThereMayBeEachInAllTroubleFits) {
  StatusReply reply;
  reply.number = 1;
  reply.status.application = std::string(64, 'a');
  LoopStatus loop;
  loop.name = loop.culprit = std::string(64, 'l');
  loop.forces = device::ForceCondition{device::ForceState::degraded, device::ForceFault::outside_workspace};
  loop.late_octaves.assign(40, std::uint64_t{1} << 62);
  reply.status.loops.assign(8, loop);
  ClientStatus client{std::string(64, 'c'), Role::graphics, {}};
  client.figures.conditions.assign(5, {device::HealthCode::physics_server_gone, 1e8, std::string(300, 'w')});
  reply.status.clients.assign(64, client);
  const std::string bytes = encode(ServerMessage(reply));
  EXPECT_LE(bytes.size(), kMaxMessageBytes);
  const auto back = decode_server_message(bytes);
  ASSERT_TRUE(back) << back.error().message;
  const auto& told = std::get<StatusReply>(*back).status.clients.back().figures.conditions;
  ASSERT_EQ(told.size(), 4u);
  for (const auto& one : told) EXPECT_EQ(one.words, std::string(177, 'w') + "...");
}

// A driver's words may be among them: the message arrives nevertheless.
TEST(Messages, OurOwnTextsAreMadeFitToBeShown) {
  const std::string odd = "a\u202E\x1B[31m", fit = "a??[31m";
  ClientFigures figures;
  figures.conditions = {{device::HealthCode::camera_silent, 0.0, odd}};
  const auto hello = decode_client_message(encode(ClientMessage(Hello{1, 0, odd, figures})));
  ASSERT_TRUE(hello) << hello.error().message;
  EXPECT_EQ(std::get<Hello>(*hello).name, fit);
  EXPECT_EQ(std::get<Hello>(*hello).figures->conditions[0].words, fit);
  ServerStatus status;
  status.application = odd;
  status.loops.emplace_back();
  status.loops[0].name = status.loops[0].culprit = odd;
  status.loops[0].forces = device::ForceCondition{};
  status.clients = {{odd, Role::observer, figures}};
  const auto reply = decode_server_message(encode(ServerMessage(StatusReply{1, status})));
  ASSERT_TRUE(reply) << reply.error().message;
  const auto& shown = std::get<StatusReply>(*reply).status;
  EXPECT_EQ(shown.application + shown.loops[0].name + shown.loops[0].culprit + shown.clients[0].name,
            fit + fit + fit + fit);
  // Cut between characters, for half a character would be refused.
  const std::string umlauts = "a" + [] {
    std::string many;
    for (int i = 0; i < 600; ++i) many += "\u00E4";
    return many;
  }();
  const auto refusal = decode_server_message(encode(ServerMessage(Refusal{umlauts})));
  ASSERT_TRUE(refusal) << refusal.error().message;
  EXPECT_GT(std::get<Refusal>(*refusal).reason.size(), 500u);
}

}  // namespace
}  // namespace palpate::transport
