// Places on a server: nobody can take those of all others.
#include "palpate/transport/internal/service_core.h"

#include <gtest/gtest.h>

#include "palpate/transport/exchange_rig_test.h"

namespace palpate::transport {
namespace {

class Places : public ::testing::Test {
 protected:
  bool welcome(std::uint64_t client, const std::string& peer, const std::string& key,
               Role role = Role::observer) {
    now += std::chrono::milliseconds(1);
    const auto answer =
        core.answer(encode(ClientMessage(Hello{client, 0, "test", {}})), now, role, peer, key);
    return std::holds_alternative<Welcome>(answer);
  }
  Instant<PhysicsClock> now{std::chrono::seconds(10)};
  ServiceCore core{testing::state_at, testing::table_scene(), 1, [this] { return now; }};
};

TEST_F(Places, OneConnectionHasOneHoweverManyNamesItTakes) {
  for (std::uint64_t id = 1; id <= 500; ++id) ASSERT_TRUE(welcome(id, "restless", ""));
  EXPECT_EQ(core.counters().clients, 1);
  EXPECT_TRUE(welcome(1000, "newcomer", ""));
  EXPECT_EQ(core.counters().clients, 2);
}

TEST_F(Places, AKeyHasItsShareAndTheOthersStillGetIn) {
  for (std::uint64_t id = 1; id <= 100; ++id)
    EXPECT_EQ(welcome(id, "greedy " + std::to_string(id), "greedy"), id <= ServiceCore::kMaxClientsOfKey);
  EXPECT_TRUE(welcome(1000, "newcomer", "other"));
  EXPECT_EQ(core.counters().rejected, 100 - ServiceCore::kMaxClientsOfKey);
}

TEST_F(Places, AClientThatComesBackOverAnotherConnectionKeepsItsPlace) {
  for (std::uint64_t id = 1; id <= ServiceCore::kMaxClientsOfKey; ++id)
    ASSERT_TRUE(welcome(id, "before " + std::to_string(id), "key"));
  EXPECT_TRUE(welcome(3, "after", "key"));
  EXPECT_EQ(core.counters().clients, static_cast<int>(ServiceCore::kMaxClientsOfKey));
}

TEST_F(Places, OfThoseWhoHaveGoneComeFreeWithinASecond) {
  for (std::uint64_t id = 1; id <= ServiceCore::kMaxClients; ++id)
    ASSERT_TRUE(welcome(id, std::to_string(id), "", Role::operator_));
  EXPECT_FALSE(welcome(1000, "newcomer", "", Role::operator_));
  now += std::chrono::milliseconds(900);
  EXPECT_TRUE(welcome(1000, "newcomer", ""));
}

TEST_F(Places, TheLastAreForOperators) {
  for (std::uint64_t id = 1; id <= ServiceCore::kMaxClients; ++id)
    EXPECT_EQ(welcome(id, std::to_string(id), ""),
              id <= ServiceCore::kMaxClients - ServiceCore::kForOperators);
  for (std::uint64_t id = 1001; id <= 1000 + ServiceCore::kForOperators; ++id)
    EXPECT_TRUE(welcome(id, std::to_string(id), "", Role::operator_));
  EXPECT_FALSE(welcome(2000, "late", "", Role::operator_));
}

}  // namespace
}  // namespace palpate::transport
