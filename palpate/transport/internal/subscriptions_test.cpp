#include "palpate/transport/internal/subscriptions.h"

#include <gtest/gtest.h>

#include <vector>

namespace palpate::transport {
namespace {

using Due = std::vector<std::pair<std::string, std::uint64_t>>;

Instant<PhysicsClock> at_s(double time_s) { return Instant<PhysicsClock>::from_seconds(time_s); }

Due due_at(Subscriptions& subscriptions, double time_s) {
  Due due;
  subscriptions.for_each_due(at_s(time_s), [&](const std::string& peer, std::uint64_t number) {
    due.emplace_back(peer, number);
    return true;
  });
  return due;
}

TEST(Subscriptions, EachGetsItsRateFromItsFirstMomentOn) {
  Subscriptions subscriptions;
  EXPECT_FALSE(subscriptions.next_due());
  ASSERT_TRUE(subscriptions.renew("a", "", 10, at_s(0.05)));
  ASSERT_TRUE(subscriptions.renew("b", "", 4, at_s(0.05)));
  EXPECT_EQ(due_at(subscriptions, 0.05), (Due{{"a", 1}, {"b", 1}}));
  EXPECT_EQ(due_at(subscriptions, 0.05), Due{});
  EXPECT_EQ(*subscriptions.next_due(), at_s(0.1));  // all of one rate together
  std::size_t a = 0, b = 0;
  for (int ms = 51; ms <= 1050; ++ms)
    for (const auto& [peer, number] : due_at(subscriptions, 0.001 * ms)) ++(peer == "a" ? a : b);
  EXPECT_EQ(a, 10u);
  EXPECT_EQ(b, 4u);
  // Slept over: one, not all that were due.
  EXPECT_EQ(due_at(subscriptions, 2.96), (Due{{"a", 12}, {"b", 6}}));
}

TEST(Subscriptions, LapseUnlessRenewedAndKeepTheirCountWhereTheyAre) {
  Subscriptions subscriptions;
  ASSERT_TRUE(subscriptions.renew("a", "", 10, at_s(0.0)));
  ASSERT_TRUE(subscriptions.renew("b", "", 10, at_s(0.0)));
  due_at(subscriptions, 0.0);
  ASSERT_TRUE(subscriptions.renew("a", "", 10, at_s(2.0)));  // no state out of turn
  EXPECT_EQ(*subscriptions.next_due(), at_s(0.1));
  subscriptions.drop_lapsed(at_s(3.0));
  EXPECT_EQ(subscriptions.size(), 2u);
  subscriptions.drop_lapsed(at_s(3.1));
  EXPECT_EQ(due_at(subscriptions, 3.1), (Due{{"a", 2}}));
  ASSERT_TRUE(subscriptions.renew("a", "", 100, at_s(3.15)));  // another rate in place of the first
  EXPECT_EQ(due_at(subscriptions, 3.15), (Due{{"a", 3}}));
  EXPECT_EQ(*subscriptions.next_due(), at_s(3.16));
  EXPECT_EQ(subscriptions.size(), 1u);
}

TEST(Subscriptions, OfConnectionsThatHaveGoneAndOfKeysTakenOutEnd) {
  Subscriptions subscriptions;
  for (const char* peer : {"a", "b", "c"})
    ASSERT_TRUE(subscriptions.renew(peer, std::string("key of ") + peer, 10, at_s(0.0)));
  subscriptions.for_each_due(at_s(0.0), [](const std::string& peer, std::uint64_t) { return peer != "b"; });
  EXPECT_EQ(due_at(subscriptions, 0.1), (Due{{"a", 2}, {"c", 2}}));
  subscriptions.keep_only([](const std::string& key) { return key == "key of c"; });
  EXPECT_EQ(due_at(subscriptions, 0.2), (Due{{"c", 3}}));
}

TEST(Subscriptions, AreBoundedInAllAndForEachKeyAndThoseThereGoOn) {
  Subscriptions subscriptions;
  for (std::size_t i = 0; i < Subscriptions::kMostOfKey; ++i)
    ASSERT_TRUE(subscriptions.renew("a" + std::to_string(i), "a", 1, at_s(0.0))) << i;
  EXPECT_FALSE(subscriptions.renew("a more", "a", 1, at_s(0.0)));
  EXPECT_TRUE(subscriptions.renew("a0", "a", 2, at_s(0.0)));
  ASSERT_TRUE(subscriptions.renew("b", "b", 1, at_s(0.0)));
  for (std::size_t i = subscriptions.size(); i < Subscriptions::kMost; ++i)
    ASSERT_TRUE(subscriptions.renew("open" + std::to_string(i), "", 1, at_s(0.0))) << i;
  const auto refusal = subscriptions.renew("c", "c", 1, at_s(0.0));
  ASSERT_FALSE(refusal);
  EXPECT_NE(refusal.error().message.find("too many subscriptions"), std::string::npos);
  EXPECT_TRUE(subscriptions.renew("b", "b", 1, at_s(2.0)));
  EXPECT_EQ(due_at(subscriptions, 2.0).size(), Subscriptions::kMost);
  subscriptions.drop_lapsed(at_s(4.0));
  EXPECT_TRUE(subscriptions.renew("c", "c", 1, at_s(4.0)));
  EXPECT_EQ(subscriptions.size(), 2u);
}

TEST(Subscriptions, AreBoundedByTheStatesTheyCost) {
  Subscriptions subscriptions;
  int peers = 0;
  for (; subscriptions.renew(std::to_string(peers), "a", 1000, at_s(0.0)); ++peers) ASSERT_LT(peers, 100);
  EXPECT_EQ(peers, Subscriptions::kMostStatesOfKey_hz / 1000);
  ASSERT_TRUE(subscriptions.renew("0", "a", 900, at_s(0.0)));
  ASSERT_TRUE(subscriptions.renew("last", "a", 100, at_s(0.0)));
  EXPECT_FALSE(subscriptions.renew("0", "a", 1000, at_s(0.0)));
  // What it had goes on.
  EXPECT_EQ(due_at(subscriptions, 0.0).size(), static_cast<std::size_t>(peers) + 1);
  for (; subscriptions.renew("open" + std::to_string(peers), "", 1000, at_s(0.0)); ++peers)
    ASSERT_LT(peers, 100);
  EXPECT_EQ(peers, Subscriptions::kMostStates_hz / 1000);
  EXPECT_FALSE(subscriptions.renew("b", "b", 1, at_s(0.0)));
}

}  // namespace
}  // namespace palpate::transport
