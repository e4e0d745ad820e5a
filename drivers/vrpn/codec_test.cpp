#include "drivers/vrpn/codec.h"

#include <gtest/gtest.h>

#include "drivers/vrpn/message_stream.h"

namespace palpate::drivers::vrpn {
namespace {

using Stamp = Instant<TrackerClock>;

const TrackerPose kPose{3, {so3_exp(Vector3(0.1, -0.4, 0.2)), Vector3(0.1, -0.2, -1.1)}};

// As the public library packs it: sizes, order and padding by hand.
TEST(Codec, AMessageIsLaidOutAsTheLibraryLaysItOut) {
  const auto bytes = *encode({Stamp{Duration(5'000'007'999)}, 2, -1, encode_name("Hand")});
  ASSERT_EQ(bytes.size(), 40u) << "24 of header, 9 of payload, filled up to 16";
  const auto word = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    return value;
  };
  EXPECT_EQ(word(0), 33u) << "header and payload, without what fills up";
  EXPECT_EQ(word(4), 5u);
  EXPECT_EQ(word(8), 7u) << "microseconds";
  EXPECT_EQ(word(12), 2u);
  EXPECT_EQ(word(16), 0xffff'ffffu);
  EXPECT_EQ(word(24), 5u) << "the name with its 0";
  EXPECT_EQ(bytes.substr(28, 5), std::string("Hand\0", 5));
  EXPECT_EQ(cookie().size(), 24u);
  EXPECT_EQ(cookie().substr(0, 14), "vrpn: ver. 07.");
  EXPECT_EQ(cookie().substr(16, 3), "  0");
}

TEST(Codec, PosesComeBackExactly) {
  const auto payload = encode_pose(kPose);
  ASSERT_EQ(payload.size(), 64u);
  const auto back = decode_pose(payload);
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->sensor, 3);
  EXPECT_EQ(back->pose.translation, kPose.pose.translation);
  EXPECT_LT(back->pose.rotation.angularDistance(kPose.pose.rotation), 1e-15);
  EXPECT_EQ(*decode_name(encode_name("Tracker0")), "Tracker0");
  EXPECT_EQ(tool_name("Tracker0", 0), "Tracker0");
  EXPECT_EQ(tool_name("Tracker0", 2), "Tracker0:2");
}

TEST(Codec, WhatIsNoPoseOrNameIsRefused) {
  EXPECT_FALSE(decode_pose(encode_pose(kPose).substr(1)));
  EXPECT_FALSE(decode_pose(encode_pose({-1, kPose.pose})));
  EXPECT_FALSE(decode_pose(encode_pose({0, {Quaternion(0.5, 0, 0, 0), Vector3::Zero()}})));
  EXPECT_FALSE(decode_pose(encode_pose({0, {Quaternion::Identity(), Vector3(std::nan(""), 0, 0)}})));
  EXPECT_FALSE(decode_pose(encode_pose({0, {Quaternion::Identity(), Vector3(1e6, 0, 0)}})));
  EXPECT_FALSE(decode_name(""));
  EXPECT_FALSE(decode_name(encode_name("")));
  EXPECT_FALSE(decode_name(encode_name("two\nlines")));
  EXPECT_FALSE(decode_name(encode_name("name").substr(0, 7)));
  EXPECT_FALSE(encode({Stamp{Duration(-1)}, 0, 0, ""}));
}

std::string greeting_and(const std::string& more) { return cookie() + more; }

TEST(Stream, PiecesOfAnySizeGiveTheSameMessages) {
  std::string bytes =
      greeting_and(*encode({Stamp::from_seconds(1), 0, kSenderDescription, encode_name("Hand")}));
  for (int i = 0; i < 5; ++i)
    bytes += *encode({Stamp::from_seconds(2 + i), 0, 7, encode_pose({i, kPose.pose})});
  for (std::size_t size = 1; size < 60; ++size) {
    MessageStream stream;
    std::vector<Message> heard;
    for (std::size_t at = 0; at < bytes.size(); at += size)
      ASSERT_TRUE(stream.take(std::string_view(bytes).substr(at, size),
                              [&](Message&& m) { heard.push_back(std::move(m)); }));
    ASSERT_EQ(heard.size(), 6u) << size;
    EXPECT_EQ(heard[0].payload, encode_name("Hand"));
    EXPECT_EQ(heard[5].stamp, Stamp::from_seconds(6));
    EXPECT_EQ(decode_pose(heard[5].payload)->sensor, 4);
  }
}

TEST(Stream, WhatIsNotVrpnIsLost) {
  const auto complaint = [](const std::string& bytes) {
    MessageStream stream;
    EXPECT_FALSE(stream.take(bytes, [](Message&&) { FAIL() << "a message"; }));
    EXPECT_FALSE(stream.take(*encode({Stamp{}, 0, 0, ""}), [](Message&&) { FAIL() << "after the end"; }));
    return stream.complaint();
  };
  EXPECT_NE(complaint("GET / HTTP/1.1\r\nHost: localhost\r\n\r\n").find("not VRPN: it begins with 'GET"),
            std::string::npos);
  std::string other = cookie();
  other[12] = '6';
  EXPECT_NE(complaint(other).find("another version"), std::string::npos);
  EXPECT_NE(complaint(greeting_and(std::string(24, '\xff'))).find("bytes"), std::string::npos);
  EXPECT_NE(complaint(greeting_and(std::string(24, '\0'))).find("of 0 bytes"), std::string::npos);
  std::string late = *encode({Stamp{}, 0, 0, ""});
  late[8] = '\x7f';
  EXPECT_NE(complaint(greeting_and(late)).find("us beside its seconds"), std::string::npos);
}

}  // namespace
}  // namespace palpate::drivers::vrpn
