#include "palpate/transport/internal/connections.h"

#include <gtest/gtest.h>

#include <set>

namespace palpate::transport {
namespace {

class ConnectionsOfAServer : public ::testing::Test {
 protected:
  static Instant<PhysicsClock> at_s(double s) { return {seconds(100.0 + s)}; }
  int comes(const std::string& source, double s = 0.0) {
    ++last;
    connections.began(0, last, static_cast<std::uint64_t>(1000 + last), source, at_s(s));
    return last;
  }
  bool speaks(const std::string& key, bool by_operator = false) {
    return connections.heard(comes("host of " + key), key, by_operator);
  }
  std::set<int> overdue(double s) {
    std::set<int> descriptors;
    for (const auto& one : connections.take_overdue(at_s(s))) {
      EXPECT_EQ(one.number, static_cast<std::uint64_t>(1000 + one.descriptor));
      descriptors.insert(one.descriptor);
    }
    return descriptors;
  }
  Connections connections;
  int last = 0;
};

TEST_F(ConnectionsOfAServer, WhoSpeaksStaysAndWhoDoesNotEnds) {
  const int client = comes("a"), silent = comes("a");
  EXPECT_TRUE(connections.heard(client, "key", false));
  EXPECT_TRUE(overdue(1.9).empty());
  EXPECT_EQ(overdue(2.1), std::set{silent});
  EXPECT_TRUE(overdue(1000.0).empty());
  EXPECT_TRUE(connections.heard(client, "key", false));
  EXPECT_FALSE(connections.heard(silent, "key", false));  // what was under way when it ended
}

TEST_F(ConnectionsOfAServer, AKeyHasSoManyAndWhatIsBeyondIsNotHeardAndEnds) {
  for (std::size_t i = 0; i < Connections::kMostOfKey; ++i) {
    EXPECT_FALSE(connections.full("greedy"));
    EXPECT_TRUE(speaks("greedy"));
  }
  EXPECT_TRUE(connections.full("greedy"));
  EXPECT_FALSE(speaks("greedy", true));
  const int one_more = last;
  EXPECT_FALSE(connections.heard(one_more, "greedy", true));
  EXPECT_TRUE(speaks("modest"));
  EXPECT_EQ(overdue(2.1), std::set{one_more});
  connections.ended(0, 1);
  EXPECT_FALSE(connections.full("greedy"));
  EXPECT_TRUE(speaks("greedy"));
}

TEST_F(ConnectionsOfAServer, OneIsTakenByItsUserOnly) {
  const int client = comes("a"), fresh = comes("a");
  EXPECT_TRUE(connections.heard(client, "key", false));
  EXPECT_FALSE(connections.take(client, "another"));
  EXPECT_TRUE(connections.take(fresh, "key"));
  const auto taken = connections.take(client, "key");
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->descriptor, client);
  EXPECT_EQ(taken->number, static_cast<std::uint64_t>(1000 + client));
  EXPECT_FALSE(connections.take(client, "key"));
  EXPECT_EQ(connections.size(), 0u);
}

TEST_F(ConnectionsOfAServer, WithoutKeysAProcessOrHostHasSoMany) {
  for (std::size_t i = 0; i < 2 * Connections::kMostOfSource; ++i)
    EXPECT_EQ(connections.heard(comes("process 7"), "", true), i < Connections::kMostOfSource);
  EXPECT_TRUE(connections.heard(comes("process 8"), "", true));
}

TEST_F(ConnectionsOfAServer, OfManyThatAreNewThoseEndThatHaveWaitedForLongest) {
  for (std::size_t i = 0; i < 1000; ++i) comes("a", 1e-4 * static_cast<double>(i));
  const auto ended = overdue(0.1);
  EXPECT_EQ(ended.size(), 1000 - Connections::kMostNew);
  EXPECT_EQ(*ended.rbegin(), static_cast<int>(ended.size()));  // and no later one
  EXPECT_EQ(overdue(0.5).size(), Connections::kMostNew);       // where many are new they have less time
}

TEST_F(ConnectionsOfAServer, AFloodFromOneHostDoesNotPushOutWhoComesFromAnother) {
  const int honest = comes("b");
  for (int i = 0; i < 1000; ++i) comes("a", 0.01);
  EXPECT_EQ(overdue(0.1).count(honest), 0u);
  EXPECT_TRUE(connections.heard(honest, "key", false));
}

TEST_F(ConnectionsOfAServer, TheLastPlacesAreForOperatorsHoweverFewThereAre) {
  for (const std::size_t places : {Connections::kMost, std::size_t{60}, std::size_t{20}}) {
    connections = {};
    connections.set_places(places);
    std::size_t observers = 0, operators = 0;
    while (speaks(std::to_string(last))) ++observers;
    while (speaks(std::to_string(last), true)) ++operators;
    EXPECT_GE(observers, places / 3) << places;
    EXPECT_GE(operators, std::min(Connections::kForOperators, places / 16)) << places;
    EXPECT_EQ(overdue(0.0).size() + connections.size(), observers + operators + 2) << places;
    EXPECT_LE(connections.size(), places) << places;
  }
}

TEST_F(ConnectionsOfAServer, WhereTheLimitIsLoweredThoseThereStayAndNobodyComes) {
  for (const char* key : {"a", "b", "c"}) ASSERT_TRUE(speaks(key));
  connections.set_places(0);
  const int late = comes("d");
  EXPECT_FALSE(connections.heard(late, "d", true));
  EXPECT_EQ(overdue(0.0), std::set{late});
  EXPECT_EQ(connections.size(), 3u);
  EXPECT_TRUE(connections.heard(1, "a", false));
}

TEST_F(ConnectionsOfAServer, AnEndThatIsToldLateEndsNotWhoHasTheDescriptorNow) {
  connections.began(1, comes("a"), 7, "b", at_s(0.1));
  connections.ended(0, last);
  EXPECT_TRUE(connections.heard(last, "key", false));
  connections.ended(1, last);
  EXPECT_EQ(connections.size(), 0u);
}

// The message of a connection that has ended may be read after another has got its descriptor.
TEST_F(ConnectionsOfAServer, ADescriptorBelongsToWhoSpokeThereLast) {
  const int descriptor = comes("a");
  EXPECT_TRUE(connections.heard(descriptor, "before", false));
  EXPECT_TRUE(connections.heard(descriptor, "now", false));
  EXPECT_EQ(connections.of_user("before"), 0u);
  EXPECT_EQ(connections.of_user("now"), 1u);
}

}  // namespace
}  // namespace palpate::transport
