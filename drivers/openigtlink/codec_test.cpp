#include "drivers/openigtlink/codec.h"

#include <gtest/gtest.h>

#include "palpate/math/random_vector.h"

namespace palpate::drivers::openigtlink {
namespace {

std::string from_hex(std::string_view hex) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<char>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
  return bytes;
}

std::string big_endian(std::uint64_t value, int bytes) {
  std::string text;
  for (int i = bytes - 1; i >= 0; --i) text.push_back(static_cast<char>(value >> (8 * i)));
  return text;
}

std::string padded(std::string text, std::size_t size) {
  text.resize(size, '\0');
  return text;
}

std::string with_header(int version, const std::string& type, const std::string& body) {
  return big_endian(static_cast<std::uint64_t>(version), 2) + padded(type, 12) + padded("Device", 20) +
         big_endian(0, 8) + big_endian(body.size(), 8) + big_endian(crc64(body), 8) + body;
}

Expected<Message> decode(std::string_view bytes) {
  const auto header = decode_header(bytes.substr(0, kHeaderBytes));
  if (!header) return tl::unexpected(header.error());
  return decode_body(*header, bytes.substr(kHeaderBytes));
}

// Written by struct.pack and a CRC bit by bit in Python from the specification: a quarter turn about z, (10,
// -20, 30.5) mm, at 1234567890.5 s.
const std::string kQuarterTurn = from_hex(
    "00015452414e53464f524d0000005374796c7573546f547261636b65720000000000499602d28000000000000000000000309c76"
    "63f5f9cd7b70000000003f80000000000000bf800000000000000000000000000000000000003f80000041200000c1a0000041f4"
    "0000");

TEST(Crc64, AgreesWithThePublishedCheckValue) {
  EXPECT_EQ(crc64("123456789"), 0x6C40DF5F0B497347ull);  // CRC-64/ECMA-182 in the catalogue of CRCs
  EXPECT_EQ(crc64(""), 0u);
}

TEST(Codec, ReadsATransformWrittenByHand) {
  const auto message = decode(kQuarterTurn);
  ASSERT_TRUE(message.has_value()) << message.error().message;
  EXPECT_EQ(message->device, "StylusToTracker");
  ASSERT_TRUE(message->stamp.has_value());
  EXPECT_EQ(message->stamp->ns(), 1234567890'500000000);
  const auto& transform = std::get<Transform>(message->content);
  EXPECT_TRUE(transform.valid);
  EXPECT_LT((transform.pose.translation - Vector3(0.010, -0.020, 0.0305)).norm(), 1e-12);
  EXPECT_LT((transform.pose.rotation * Vector3::UnitX() - Vector3::UnitY()).norm(), 1e-12);
}

TEST(Codec, WritesTheBytesWrittenByHand) {
  const RigidPose pose{so3_exp(Vector3(0, 0, std::numbers::pi / 2)), Vector3(0.010, -0.020, 0.0305)};
  const auto bytes =
      encode({"StylusToTracker", Instant<TrackerClock>::from_seconds(1234567890.5), Transform{pose}});
  ASSERT_TRUE(bytes.has_value()) << bytes.error().message;
  EXPECT_EQ(bytes->size(), kQuarterTurn.size());
  EXPECT_EQ(bytes->substr(0, 50), kQuarterTurn.substr(0, 50)) << "all of the header but the CRC";
  const auto read = decode(*bytes);  // cos of a quarter turn is 2e-16, not the 0 written by hand
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_LT(angle_between(std::get<Transform>(read->content).pose.rotation, pose.rotation), 1e-7);
}

TEST(Codec, RoundTripsPosesToSinglePrecision) {
  Random random(1, "igtl/round-trip");
  for (int i = 0; i < 500; ++i) {
    TrackingData data;
    for (int k = 0; k < 3; ++k)
      data.tools.push_back({fmt::format("tool {}", k),
                            static_cast<std::uint8_t>(1 + k),
                            {so3_exp(uniform3(random, 3.0)), uniform3(random, 4.0)}});
    const auto stamp = Instant<TrackerClock>{Duration(static_cast<std::int64_t>(random.below(1ull << 61)))};
    const auto bytes = encode({"Tracker", stamp, data});
    ASSERT_TRUE(bytes.has_value()) << bytes.error().message;
    const auto read = decode(*bytes);
    ASSERT_TRUE(read.has_value()) << read.error().message;
    EXPECT_EQ(read->stamp, stamp) << "the wire's fraction is finer than a nanosecond";
    const auto& tools = std::get<TrackingData>(read->content).tools;
    ASSERT_EQ(tools.size(), 3u);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_EQ(tools[k].name, data.tools[k].name);
      EXPECT_EQ(tools[k].type, data.tools[k].type);
      // float32: 6e-8 of 4 m per component; of 1 per matrix element
      EXPECT_LT((tools[k].pose.translation - data.tools[k].pose.translation).norm(), 5e-7);
      EXPECT_LT(angle_between(tools[k].pose.rotation, data.tools[k].pose.rotation), 5e-7);
    }
  }
}

TEST(Codec, RoundTripsStatusAndStartRequests) {
  const auto status = decode(*encode({"Tracker", {}, Status{3, -7, "Failure", "no tool in sight"}}));
  ASSERT_TRUE(status.has_value()) << status.error().message;
  EXPECT_FALSE(status->stamp.has_value());
  EXPECT_EQ(std::get<Status>(status->content).code, 3);
  EXPECT_EQ(std::get<Status>(status->content).subcode, -7);
  EXPECT_EQ(std::get<Status>(status->content).name, "Failure");
  EXPECT_EQ(std::get<Status>(status->content).text, "no tool in sight");
  const auto start = decode(*encode({"", {}, StartTracking{20, "Patient"}}));
  ASSERT_TRUE(start.has_value()) << start.error().message;
  EXPECT_EQ(std::get<StartTracking>(start->content).resolution_ms, 20);
  EXPECT_EQ(std::get<StartTracking>(start->content).coordinates, "Patient");
  const auto stop = encode({"", {}, StopTracking{}});
  EXPECT_EQ(stop->size(), kHeaderBytes);
  EXPECT_TRUE(std::holds_alternative<StopTracking>(decode(*stop)->content));
}

TEST(Codec, StampsAreFixedPointAndZeroIsNoTime) {
  EXPECT_FALSE(stamp_from_wire(0).has_value());
  EXPECT_EQ(*wire_from_stamp(std::nullopt), 0u);
  EXPECT_EQ(stamp_from_wire(0x0000000180000000ull)->ns(), 1'500'000'000);
  EXPECT_EQ(stamp_from_wire(*wire_from_stamp(Instant<TrackerClock>{}))->ns(), 0) << "0 s is a time";
  EXPECT_EQ(stamp_from_wire(*wire_from_stamp(Instant<TrackerClock>{Duration(999'999'999)}))->ns(),
            999'999'999);
  EXPECT_EQ(stamp_from_wire(~0ull)->ns(), 4294967295'999999999) << "the last time there is can be sent on";
  EXPECT_TRUE(wire_from_stamp(stamp_from_wire(~0ull)).has_value());
  EXPECT_FALSE(wire_from_stamp(Instant<TrackerClock>{Duration(-1)}).has_value());
  EXPECT_FALSE(wire_from_stamp(Instant<TrackerClock>::from_seconds(4294967296.0)).has_value());
}

TEST(Codec, PassesOverTheExtendedHeaderAndMetadataOfLaterVersions) {
  const std::string content = kQuarterTurn.substr(kHeaderBytes);
  const auto later = [&](int version, std::size_t extension, const std::string& status) {
    const std::string key = "TransformStatus", other = "Unit", value = "mm";
    const std::string index = big_endian(2, 2) + big_endian(other.size(), 2) + big_endian(3, 2) +
                              big_endian(value.size(), 4) + big_endian(key.size(), 2) + big_endian(3, 2) +
                              big_endian(status.size(), 4);
    const std::string texts = other + value + key + status;
    return with_header(version, "TRANSFORM",
                       padded(big_endian(extension, 2) + big_endian(index.size(), 2) +
                                  big_endian(texts.size(), 4) + big_endian(42, 4),
                              extension) +
                           content + index + texts);
  };
  for (const int version : {2, 3})
    for (const std::size_t extension : {12u, 20u}) {
      const auto seen = decode(later(version, extension, "OK"));
      ASSERT_TRUE(seen.has_value()) << seen.error().message;
      EXPECT_TRUE(std::get<Transform>(seen->content).valid);
      EXPECT_LT((std::get<Transform>(seen->content).pose.translation - Vector3(0.010, -0.020, 0.0305)).norm(),
                1e-12);
      const auto hidden = decode(later(version, extension, "OUT_OF_VIEW"));
      ASSERT_TRUE(hidden.has_value()) << hidden.error().message;
      EXPECT_FALSE(std::get<Transform>(hidden->content).valid);
    }
  EXPECT_FALSE(decode(with_header(2, "TRANSFORM", content)).has_value()) << "no extended header";
  EXPECT_FALSE(decode(with_header(2, "TRANSFORM", big_endian(12, 2))).has_value());
  EXPECT_FALSE(
      decode(with_header(2, "TRANSFORM", padded(big_endian(12, 2) + big_endian(0xFFFF, 2), 12) + content))
          .has_value())
      << "metadata longer than the body";
}

// Packed by the library of OpenIGTLink 3.1 (header version 2, metadata): the quarter turn above, seen and out
// of view, and as tracking data.
const std::string kSeenByLibrary = from_hex(
    "00025452414e53464f524d0000005374796c7573546f547261636b65720000000000499602d280000000000000000000006ecdbe"
    "394d802d0000000c0012000000200000002a000000003f80000000000000bf800000000000000000000000000000000000003f80"
    "000041200000c1a0000041f400000002000f000300000002000e0003000000015472616e73666f726d5374617475734f4b547261"
    "6e73666f726d56616c696431");
const std::string kHiddenByLibrary = from_hex(
    "00025452414e53464f524d0000005374796c7573546f547261636b65720000000000499602d280000000000000000000007799f1"
    "dc395225cf25000c0012000000290000002a000000003f80000000000000bf800000000000000000000000000000000000003f80"
    "000041200000c1a0000041f400000002000f00030000000b000e0003000000015472616e73666f726d5374617475734f55545f4f"
    "465f564945575472616e73666f726d56616c696430");
const std::string kToolByLibrary = from_hex(
    "0002544441544100000000000000547261636b657200000000000000000000000000499602d2800000000000000000000054a730"
    "2a55daecb8af000c000200000000000000004e6565646c6500000000000000000000000000000200000000003f80000000000000"
    "bf800000000000000000000000000000000000003f80000041200000c1a0000041f400000000");

TEST(Codec, ReadsWhatTheLibraryOfVersion3Writes) {
  const auto seen = decode(kSeenByLibrary), hidden = decode(kHiddenByLibrary), tool = decode(kToolByLibrary);
  ASSERT_TRUE(seen.has_value()) << seen.error().message;
  ASSERT_TRUE(hidden.has_value()) << hidden.error().message;
  ASSERT_TRUE(tool.has_value()) << tool.error().message;
  const auto& transform = std::get<Transform>(seen->content);
  EXPECT_TRUE(transform.valid);
  EXPECT_LT((transform.pose.translation - Vector3(0.010, -0.020, 0.0305)).norm(), 1e-12);
  EXPECT_LT((transform.pose.rotation * Vector3::UnitX() - Vector3::UnitY()).norm(), 1e-12);
  EXPECT_LT(std::abs(seen->stamp->ns() - 1234567890'500000000), 2);
  EXPECT_FALSE(std::get<Transform>(hidden->content).valid);
  const auto& tools = std::get<TrackingData>(tool->content).tools;
  ASSERT_EQ(tools.size(), 1u);
  EXPECT_EQ(tools[0].name, "Needle");
  EXPECT_LT((tools[0].pose.translation - Vector3(0.010, -0.020, 0.0305)).norm(), 1e-12);
}

TEST(Codec, RefusesEveryTruncation) {
  for (std::size_t size = 0; size < kQuarterTurn.size(); ++size)
    EXPECT_FALSE(decode(std::string_view(kQuarterTurn).substr(0, size)).has_value()) << size;
  // and where header and CRC agree with what is left
  const std::string body = kQuarterTurn.substr(kHeaderBytes);
  const auto readable = [&](const char* type, std::size_t size) {
    return decode(with_header(1, type, body.substr(0, size))).has_value();
  };
  for (std::size_t size = 0; size < body.size(); ++size) {
    EXPECT_FALSE(readable("TRANSFORM", size)) << size;
    EXPECT_EQ(readable("TDATA", size), size == 0) << size;
    EXPECT_EQ(readable("STATUS", size), size >= 30) << size;
    EXPECT_EQ(readable("STT_TDATA", size), size == 36) << size;
  }
}

TEST(Codec, NoticesEveryFlippedBitOfTheBody) {
  for (std::size_t at = kHeaderBytes; at < kQuarterTurn.size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = kQuarterTurn;
      damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
      EXPECT_FALSE(decode(damaged).has_value()) << at << ' ' << bit;
    }
}

TEST(Codec, RefusesWhatIsNoRigidMotion) {
  const auto with_first = [](std::uint32_t word) {
    return decode(with_header(1, "TRANSFORM", big_endian(word, 4) + kQuarterTurn.substr(kHeaderBytes + 4)));
  };
  EXPECT_TRUE(with_first(0).has_value());
  EXPECT_FALSE(with_first(0x7FC00000).has_value()) << "NaN";
  EXPECT_FALSE(with_first(0x7F800000).has_value()) << "infinity";
  EXPECT_FALSE(with_first(0x3F000000).has_value()) << "0.5: skewed";
  EXPECT_FALSE(decode(with_header(1, "TRANSFORM", std::string(48, '\0'))).has_value()) << "zeros";
}

TEST(Codec, RefusesWhatNoSenderWrites) {
  EXPECT_FALSE(decode_header(std::string(kHeaderBytes, '\0')).has_value());
  EXPECT_FALSE(decode_header("HTTP/1.1 400 Bad Request\r\nConnection: close\r\n\r\n          ").has_value());
  EXPECT_FALSE(decode_header(with_header(4, "TRANSFORM", "")).has_value());
  EXPECT_FALSE(decode_header(with_header(1, "", "")).has_value());
  EXPECT_FALSE(decode_header(with_header(1, "TRANS FORM", "")).has_value());
}

TEST(Codec, WillNotWriteWhatCannotBeRead) {
  EXPECT_FALSE(
      encode({"a", {}, Transform{{Quaternion::Identity(), Vector3(std::nan(""), 0, 0)}}}).has_value());
  EXPECT_FALSE(encode({"a", {}, Transform{{Quaternion(2, 0, 0, 0), Vector3::Zero()}}}).has_value());
  EXPECT_FALSE(encode({"a", {}, TrackingData{std::vector<Tool>(15000)}}).has_value());
  EXPECT_FALSE(encode({"a", {}, Status{1, 0, "", std::string(kMostBodyBytes, 'x')}}).has_value());
  EXPECT_TRUE(encode({"a", {}, TrackingData{std::vector<Tool>(14979)}}).has_value());
}

TEST(Codec, NamesAreCutAndHoldNoControlCharacters) {
  const auto message = decode(*encode({"ANameOfMoreThanTwentyBytes", {}, Transform{}}));
  EXPECT_EQ(message->device, "ANameOfMoreThanTwent");
  EXPECT_EQ(decode(*encode({"bell\a\x1b[31m", {}, Transform{}}))->device, "bell??[31m");
}

}  // namespace
}  // namespace palpate::drivers::openigtlink
