#include "tools/console/viewer_talk.h"

#include <gtest/gtest.h>

#include <set>

#include "palpate/core/json.h"

namespace palpate::tools::console {
namespace {

TEST(ViewerTalk, SaysWhoItIsAndWhatThereIs) {
  const auto texts = ViewerTalk::greeting("pingpong");
  ASSERT_EQ(texts.size(), 2u);
  const Json info = Json::parse(texts[0]), offered = Json::parse(texts[1]);
  EXPECT_EQ(info["op"], "serverInfo");
  EXPECT_EQ(info["name"], "Palpate: pingpong");
  EXPECT_TRUE(info["capabilities"].is_array());
  EXPECT_EQ(offered["op"], "advertise");
  std::set<std::uint32_t> ids;
  std::set<std::string> topics;
  for (const Json& channel : offered["channels"]) {
    ids.insert(channel["id"].get<std::uint32_t>());
    topics.insert(channel["topic"].get<std::string>());
    EXPECT_EQ(channel["encoding"], "protobuf");
    EXPECT_EQ(channel["schemaEncoding"], "protobuf");
    EXPECT_GT(channel["schema"].get<std::string>().size(), 100u);
  }
  EXPECT_EQ(ids.size(), viewer_channels().size());
  EXPECT_EQ(topics, (std::set<std::string>{"/physics/state", "/tf", "/scene", "/plot", "/status", "/log",
                                           "/graphics/picture"}));
  EXPECT_EQ(viewer_channels()[static_cast<std::size_t>(Channel::log) - 1].topic, "/log");
}

TEST(ViewerTalk, WrapsAMessageForEachSubscription) {
  ViewerTalk talk;
  EXPECT_FALSE(talk.wants(Channel::frames));
  EXPECT_TRUE(talk.wrap(Channel::frames, 1, "x").empty());
  ASSERT_TRUE(talk.take(
      R"({"op":"subscribe","subscriptions":[{"id":258,"channelId":2},{"id":7,"channelId":2},{"id":8,"channelId":4}]})"));
  EXPECT_TRUE(talk.wants(Channel::frames));
  EXPECT_TRUE(talk.wants(Channel::plot));
  EXPECT_FALSE(talk.wants(Channel::scene));
  const auto wrapped = talk.wrap(Channel::frames, 0x0102030405060708, "abc");
  ASSERT_EQ(wrapped.size(), 2u);
  const std::string time("\x08\x07\x06\x05\x04\x03\x02\x01", 8);
  EXPECT_EQ(wrapped[0], std::string("\x01\x07\0\0\0", 5) + time + "abc");
  EXPECT_EQ(wrapped[1], std::string("\x01\x02\x01\0\0", 5) + time + "abc");
  ASSERT_TRUE(talk.take(R"({"op":"unsubscribe","subscriptionIds":[7,99]})"));
  EXPECT_EQ(talk.wrap(Channel::frames, 1, "x").size(), 1u);
}

TEST(ViewerTalk, RefusesInWordsWhatItDoesNotServe) {
  ViewerTalk talk;
  for (const char* bad :
       {"", "null", "[]", "{", "{\"op\":3}", R"({"op":"advertise"})", R"({"op":"subscribe"})",
        R"({"op":"subscribe","subscriptions":3})", R"({"op":"subscribe","subscriptions":[3]})",
        R"({"op":"subscribe","subscriptions":[{"id":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":0}]})",
        R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":8}]})",
        R"({"op":"subscribe","subscriptions":[{"id":4294967296,"channelId":1}]})",
        R"({"op":"unsubscribe"})"}) {
    const auto done = talk.take(bad);
    ASSERT_FALSE(done) << bad;
    EXPECT_NE(done.error().message.find("expected"), std::string::npos)
        << bad << ": " << done.error().message;
  }
  for (std::uint32_t channel = 1; channel <= viewer_channels().size(); ++channel)
    EXPECT_FALSE(talk.wants(static_cast<Channel>(channel)));
}

TEST(ViewerTalk, HoldsSoManySubscriptions) {
  ViewerTalk talk;
  Json many{{"op", "subscribe"}, {"subscriptions", Json::array()}};
  for (std::size_t i = 0; i <= ViewerTalk::kMostSubscriptions; ++i)
    many["subscriptions"].push_back({{"id", i}, {"channelId", 1}});
  const auto done = talk.take(many.dump());
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().message.find("remove some"), std::string::npos);
  EXPECT_EQ(talk.wrap(Channel::state, 1, "x").size(), ViewerTalk::kMostSubscriptions);
}

}  // namespace
}  // namespace palpate::tools::console
