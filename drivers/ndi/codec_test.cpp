#include "drivers/ndi/codec.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "drivers/ndi/reply_stream.h"

namespace palpate::drivers::ndi {
namespace {

using Stamp = Instant<TrackerClock>;
using State = Reading::State;

const network::RigidPose kPose{so3_exp(Vector3(0.1, -0.4, 0.2)), Vector3(0.1, -0.2, -1.1)};

std::string bytes_of(std::initializer_list<int> bytes) {
  std::string text;
  for (const int byte : bytes) text += static_cast<char>(byte);
  return text;
}

std::string little_endian(float number) {
  const auto word = std::bit_cast<std::uint32_t>(number);
  return bytes_of({static_cast<int>(word & 0xff), static_cast<int>(word >> 8 & 0xff),
                   static_cast<int>(word >> 16 & 0xff), static_cast<int>(word >> 24)});
}

// "123456789" gives BB3D with this polynomial in every table of checksums; the API's guide shows OKAYA896.
TEST(Codec, ChecksumsAreThoseOfTheGuide) {
  EXPECT_EQ(checksum("123456789"), 0xbb3d);
  EXPECT_EQ(encode_text("OKAY"), "OKAYA896\r");
  EXPECT_EQ(encode_command("INIT:"), "INIT:E3A5\r");
  EXPECT_EQ(encode_text("RESET"), "RESETBE6F\r");
}

TEST(Codec, CommandsComeWithAndWithoutChecksum) {
  const auto with = decode_command("PENA:0AD" + fmt::format("{:04X}", checksum("PENA:0AD")));
  ASSERT_TRUE(with.has_value());
  EXPECT_EQ(with->name, "PENA");
  EXPECT_EQ(with->parameters, "0AD");
  EXPECT_EQ(decode_command("BX2 --6d=tools --3d=none")->parameters, "--6d=tools --3d=none");
  EXPECT_EQ(decode_command("TSTOP")->name, "TSTOP");
  EXPECT_EQ(decode_command("PENA:0AD0000").error(), Code::wrong_checksum);
  EXPECT_EQ(decode_command("INIT:").error(), Code::too_short);
  EXPECT_EQ(decode_command("INIT:12x4").error(), Code::wrong_checksum);
  EXPECT_EQ(decode_command("").error(), Code::unknown_command);
  EXPECT_EQ(decode_command("hello").error(), Code::unknown_command);
  EXPECT_EQ(decode_command("INIT;0000").error(), Code::unknown_command);
  EXPECT_EQ(decode_command(std::string(5000, 'A')).error(), Code::too_long);
}

TEST(Codec, ErrorsAreToldInWords) {
  EXPECT_EQ(encode_error(Code::unknown_command), "ERROR016BC2\r");
  EXPECT_EQ(error_of("ERROR2D"), Code::handles_full);
  EXPECT_FALSE(error_of("OKAY"));
  EXPECT_FALSE(error_of("ERROR"));
  EXPECT_FALSE(error_of("ERRORxx"));
  for (int code = 0; code < 256; ++code) EXPECT_FALSE(words_of(static_cast<Code>(code)).empty());
  EXPECT_EQ(words_of(Code::not_in_this_mode), "not while it is in this mode");
}

TEST(Codec, ListsOfHandles) {
  const auto handles = decode_handles("02010010A031");
  ASSERT_TRUE(handles.has_value());
  ASSERT_EQ(handles->size(), 2u);
  EXPECT_EQ((*handles)[0].number, 1);
  EXPECT_EQ((*handles)[0].status, 0x001);
  EXPECT_EQ((*handles)[1].number, 10);
  EXPECT_EQ((*handles)[1].status, 0x031);
  EXPECT_EQ(encode_handles(*handles), "02010010A031");
  EXPECT_TRUE(decode_handles("00")->empty());
  for (const char* bad : {"", "0", "01", "010100", "0101001x", "FF01001", "0g01001", "01 1001", "+101001"})
    EXPECT_FALSE(decode_handles(bad)) << bad;
  EXPECT_EQ(*decode_handle("0A"), 10);
  for (const char* bad : {"", "A", "0a", "0AB", "-1"}) EXPECT_FALSE(decode_handle(bad)) << bad;
}

TEST(Codec, WhatAToolIs) {
  //                    type    maker       rev serial  st  part number
  const auto info = decode_tool_info(
      "02000000"
      "NDI         "
      "012"
      "34803156"
      "31"
      "8700339             ");
  ASSERT_TRUE(info.has_value() && info->has_value());
  EXPECT_EQ((*info)->serial_number, "34803156");
  EXPECT_EQ((*info)->part_number, "8700339");
  EXPECT_EQ((*info)->status, 0x31);
  EXPECT_EQ((*decode_tool_info(encode_tool_info(**info)))->part_number, "8700339");
  EXPECT_EQ(encode_tool_info(**info).size(), 53u);
  EXPECT_FALSE(decode_tool_info("UNOCCUPIED")->has_value());
  EXPECT_FALSE(decode_tool_info(""));
  EXPECT_FALSE(decode_tool_info(std::string(53, '\x1b')));
  EXPECT_FALSE(decode_tool_info(std::string(53, 'x')));
}

// Bytes laid out by hand, as the guide has them.
TEST(Codec, TheBytesOfBx) {
  std::string body = bytes_of({3, /**/ 1, 1});
  for (const float number : {0.5f, 0.5f, -0.5f, 0.5f, 100.0f, -200.0f, -1100.0f, 0.25f})
    body += little_endian(number);
  body += bytes_of(
      {0x31, 0, 0, 0, 0x78, 0x56, 0x34, 0x12, /**/ 2, 2, 0x31, 0, 0, 0, 9, 0, 0, 0, /**/ 3, 4, /**/ 0, 0});
  const auto readings = decode_bx(body);
  ASSERT_TRUE(readings.has_value()) << readings.error().message;
  ASSERT_EQ(readings->size(), 3u);
  const auto& seen = readings->front();
  EXPECT_EQ(seen.state, State::valid);
  EXPECT_LT((seen.pose.translation - Vector3(0.1, -0.2, -1.1)).norm(), 1e-12);
  EXPECT_LT(seen.pose.rotation.angularDistance(Quaternion(0.5, 0.5, -0.5, 0.5)), 1e-12);
  EXPECT_EQ(seen.status, 0x31u);
  EXPECT_EQ(seen.frame, 0x12345678u);
  EXPECT_EQ((*readings)[1].state, State::missing);
  EXPECT_EQ((*readings)[1].frame, 9u);
  EXPECT_EQ((*readings)[2].state, State::disabled);
  const auto again = decode_bx(encode_bx(*readings));
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(encode_bx(*again), encode_bx(*readings));
  for (std::size_t size = 0; size < body.size(); ++size)
    EXPECT_FALSE(decode_bx(body.substr(0, size))) << size;
  EXPECT_FALSE(decode_bx(body + 'x'));
}

TEST(Codec, TheColumnsOfTx) {
  Reading seen{.handle = 1, .state = State::valid, .status = 0x31, .frame = 0x2c};
  seen.pose = {Quaternion(0.5, 0.5, -0.5, 0.5), Vector3(0.1, -0.2, -1.1)};
  const Reading missing{.handle = 2, .state = State::missing, .status = 0x31, .frame = 0x2c};
  const Reading disabled{.handle = 10, .status = 0x11};
  EXPECT_EQ(encode_tx({seen, missing, disabled}),
            "03"
            "01+05000+05000-05000+05000+010000-020000-110000+00000000000310000002C\n"
            "02MISSING000000310000002C\n"
            "0ADISABLED0000001100000000\n"
            "0000");
  seen.pose.translation.x() = 10.5;  // metres: six digits hold 9999.99 mm
  EXPECT_EQ(encode_tx({seen}), "0101MISSING000000310000002C\n0000");
}

TEST(Codec, TheBytesOfBx2) {
  std::string body =
      bytes_of({1, 0, 2,    0,                                 // version, components
                7, 0, 14,   0, 0,  0, 0, 0, 9, 0, 0, 0, 1, 2,  // one of a kind that is not read
                1, 0, 0x54, 0, 0,  0, 0, 0, 1, 0, 0, 0,        // one frame, 84 bytes
                2, 0, 0,    0, 44, 0, 0, 0, 5, 0, 0, 0, 7, 0, 0, 0, 1, 0, 1, 0,  // version, components
                2, 0, 52,   0, 0,  0, 0, 0, 2, 0, 0, 0,                          // two tools
                1, 0, 0,    0});
  for (const float number : {0.5f, 0.5f, -0.5f, 0.5f, 100.0f, -200.0f, -1100.0f, 0.25f})
    body += little_endian(number);
  body += bytes_of({2, 0, 13, 1});
  const auto frames = decode_bx2(body);
  ASSERT_TRUE(frames.has_value()) << frames.error().message;
  ASSERT_EQ(frames->size(), 1u);
  const auto& frame = frames->front();
  EXPECT_EQ(frame.number, 44u);
  EXPECT_EQ(frame.stamp.ns(), 5'000'000'007);
  ASSERT_EQ(frame.tools.size(), 2u);
  EXPECT_EQ(frame.tools[0].state, State::valid);
  EXPECT_LT((frame.tools[0].pose.translation - Vector3(0.1, -0.2, -1.1)).norm(), 1e-12);
  EXPECT_EQ(frame.tools[1].state, State::missing);
  EXPECT_EQ(frame.tools[1].handle, 2);
  EXPECT_EQ(frame.tools[1].status, 13u);
  EXPECT_EQ(ndi::bytes_of(frame), 84u);
  const auto again = decode_bx2(encode_bx2(*frames));
  ASSERT_TRUE(again.has_value()) << again.error().message;
  EXPECT_EQ(encode_bx2(*again), encode_bx2(*frames));
  for (std::size_t size = 0; size < body.size(); ++size)
    EXPECT_FALSE(decode_bx2(body.substr(0, size))) << size;
}

TEST(Codec, WhatIsNoPoseIsRefused) {
  const auto refused = [](const network::RigidPose& pose) {
    Reading reading{.handle = 1, .state = State::valid, .pose = pose, .status = 0x31};
    return !decode_bx(encode_bx({reading})) && !decode_bx2(encode_bx2({{Stamp{}, 1, {reading}}}));
  };
  EXPECT_FALSE(refused(kPose));
  EXPECT_TRUE(refused({Quaternion(0.5, 0, 0, 0), Vector3::Zero()}));
  EXPECT_TRUE(refused({Quaternion::Identity(), Vector3(std::nan(""), 0, 0)}));
  // What the device writes where it has no number: -3.697314e28.
  EXPECT_TRUE(refused({Quaternion::Identity(), Vector3(-3.697314e25, 0, 0)}));
  Frame late{Stamp::from_seconds(5.0), 1, {}};
  auto bytes = encode_bx2({late});
  bytes[4 + 12 + 12 + 3] = '\x7f';  // of the nanoseconds
  EXPECT_FALSE(decode_bx2(bytes));
}

std::vector<Reply> replies_in(const std::string& bytes, std::size_t size) {
  ReplyStream stream;
  std::vector<Reply> heard;
  for (std::size_t at = 0; at < bytes.size(); at += size)
    EXPECT_TRUE(stream.take(std::string_view(bytes).substr(at, size),
                            [&](Reply&& reply) { heard.push_back(std::move(reply)); }));
  return heard;
}

TEST(Stream, PiecesOfAnySizeGiveTheSameReplies) {
  const std::string large(70'000, 'x');  // needs the longer header
  const auto bytes = encode_text("OKAY") + encode_binary("body") + encode_text("0201001") +
                     encode_binary("") + encode_binary(large) + encode_text("a\nb\n");
  EXPECT_EQ(encode_binary("body").substr(0, 4), bytes_of({0xc4, 0xa5, 4, 0}));
  EXPECT_EQ(encode_binary(large).substr(0, 6), bytes_of({0xc8, 0xa5, 0x70, 0x11, 1, 0}));
  for (const std::size_t size : {1, 2, 3, 5, 7, 64, 4096, 100'000}) {
    const auto heard = replies_in(bytes, size);
    ASSERT_EQ(heard.size(), 6u) << size;
    EXPECT_EQ(heard[0].content, "OKAY");
    EXPECT_TRUE(heard[1].binary && heard[1].content == "body");
    EXPECT_TRUE(heard[3].binary && heard[3].content.empty());
    EXPECT_EQ(heard[4].content, large);
    EXPECT_EQ(heard[5].content, "a\nb\n");
    for (const auto& reply : heard) EXPECT_FALSE(reply.damaged);
  }
}

// A reply whose bits were changed is told to be damaged, or the stream is lost; it is never taken for whole.
TEST(Stream, AChangedBitNeverPassesForAReply) {
  Reading reading{.handle = 1, .state = State::valid, .pose = kPose, .status = 0x31, .frame = 7};
  for (const std::string& bytes : {encode_text("OKAY"), encode_binary(encode_bx({reading})),
                                   encode_binary(encode_bx2({{Stamp::from_seconds(3), 7, {reading}}}))})
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      std::string changed = bytes;
      changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ 1 << bit % 8);
      ReplyStream stream;
      stream.take(changed, [&](Reply&& reply) { EXPECT_TRUE(reply.damaged) << "bit " << bit; });
    }
}

TEST(Stream, WhatIsNotTheCombinedApiIsLost) {
  const auto complaint = [](const std::string& bytes) {
    ReplyStream stream;
    EXPECT_FALSE(stream.take(bytes, [](Reply&&) { FAIL() << "a reply"; }));
    EXPECT_FALSE(stream.take(encode_text("OKAY"), [](Reply&&) { FAIL() << "after the end"; }));
    return stream.complaint();
  };
  EXPECT_NE(complaint("\x01\x02").find("begins with the byte 01"), std::string::npos);
  EXPECT_NE(complaint("\xc4hello").find("a start is expected"), std::string::npos);
  EXPECT_NE(complaint(std::string(10'000, 'x')).find("goes on for more than"), std::string::npos);
  std::string header = encode_binary("body");
  header[2] = 5;
  EXPECT_NE(complaint(header).find("changed on its way"), std::string::npos);
  const auto huge = bytes_of({0xc8, 0xa5, 0xff, 0xff, 0xff, 0x7f});
  const auto crc = checksum(huge);
  EXPECT_NE(complaint(huge + bytes_of({crc & 0xff, crc >> 8})).find("at most"), std::string::npos);
}

}  // namespace
}  // namespace palpate::drivers::ndi
