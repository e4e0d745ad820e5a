#include "drivers/vrpn/codec.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "palpate/core/text.h"

namespace palpate::drivers::vrpn {
namespace {

constexpr std::string_view kMagic = "vrpn: ver. 07.38";  // what counts stands before the last point
constexpr std::size_t kMajor = 14;                       // "vrpn: ver. 07."
constexpr std::int64_t kMicro = 1'000, kSecond = 1'000'000'000;
constexpr std::size_t kPoseBytes = 64;
constexpr double kFarthest = 1e4;     // m
constexpr double kUnitWithin = 0.02;  // of a quaternion's length

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) word = word << 8 | static_cast<unsigned char>(bytes[at + i]);
  return word;
}
std::int32_t int_at(std::string_view bytes, std::size_t at) {
  return static_cast<std::int32_t>(word_at(bytes, at));
}
double double_at(std::string_view bytes, std::size_t at) {
  return std::bit_cast<double>(std::uint64_t{word_at(bytes, at)} << 32 | word_at(bytes, at + 4));
}
void put(std::uint32_t word, std::string& bytes) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(word >> shift & 0xff);
}
void put(std::int32_t number, std::string& bytes) { put(static_cast<std::uint32_t>(number), bytes); }
void put(double number, std::string& bytes) {
  const auto bits = std::bit_cast<std::uint64_t>(number);
  put(static_cast<std::uint32_t>(bits >> 32), bytes);
  put(static_cast<std::uint32_t>(bits), bytes);
}

bool is_name(std::string_view name) {
  return !name.empty() && name.size() <= kMostNameBytes &&
         std::all_of(name.begin(), name.end(), [](char c) { return c >= ' ' && c < 127; });
}

}  // namespace

std::string cookie() {
  std::string bytes(kMagic);
  bytes += "  0";  // nothing of this connection is to be logged
  bytes.resize(kCookieBytes, '\0');
  return bytes;
}

Expected<void> check_cookie(std::string_view bytes) {
  if (bytes.substr(0, kMajor) == kMagic.substr(0, kMajor)) return {};
  if (bytes.substr(0, 6) == kMagic.substr(0, 6))
    return refused("VRPN of another version ('{}'); version 07 is expected",
                   excerpt(bytes.substr(0, kMagic.size()), 40));
  return refused("not VRPN: it begins with '{}'; its version is expected",
                 excerpt(bytes.substr(0, kMagic.size()), 40));
}

Expected<Header> decode_header(std::string_view bytes) {
  const std::uint32_t length = word_at(bytes, 0), seconds = word_at(bytes, 4), micros = word_at(bytes, 8);
  if (length < kHeaderBytes || length - kHeaderBytes > kMostPayload)
    return refused("not VRPN: a message of {} bytes; {} to {} are expected", length, kHeaderBytes,
                   kHeaderBytes + kMostPayload);
  if (micros >= 1'000'000)
    return refused("not VRPN: a time of {} us beside its seconds; less is expected", micros);
  Header header;
  header.payload_bytes = length - kHeaderBytes;
  header.stamp = Instant<TrackerClock>{Duration(seconds * kSecond + micros * kMicro)};
  header.sender = int_at(bytes, 12);
  header.type = int_at(bytes, 16);
  return header;
}

Expected<std::string> encode(const Message& message) {
  const std::int64_t ns = message.stamp.ns();
  if (ns < 0 || ns / kSecond > std::int64_t{0xffff'ffff})
    return refused("a stamp of {:.0f} s cannot be written in VRPN; 0 to 4294967295 s is expected",
                   message.stamp.seconds());
  std::string bytes;
  put(static_cast<std::uint32_t>(kHeaderBytes + message.payload.size()), bytes);
  put(static_cast<std::uint32_t>(ns / kSecond), bytes);
  put(static_cast<std::uint32_t>(ns % kSecond / kMicro), bytes);
  put(message.sender, bytes);
  put(message.type, bytes);
  put(std::uint32_t{0}, bytes);
  bytes += message.payload;
  bytes.resize((bytes.size() + 7) / 8 * 8, '\0');
  return bytes;
}

Expected<TrackerPose> decode_pose(std::string_view payload) {
  if (payload.size() != kPoseBytes)
    return refused("a pose of {} bytes; {} are expected", payload.size(), kPoseBytes);
  TrackerPose pose;
  pose.sensor = int_at(payload, 0);
  if (pose.sensor < 0) return refused("a pose of sensor {}; 0 and above are expected", pose.sensor);
  for (int i = 0; i < 3; ++i)
    pose.pose.translation[i] = double_at(payload, 8 + 8 * static_cast<std::size_t>(i));
  const double x = double_at(payload, 32), y = double_at(payload, 40), z = double_at(payload, 48),
               w = double_at(payload, 56);
  const Quaternion q(w, x, y, z);
  if (!pose.pose.translation.allFinite() || pose.pose.translation.cwiseAbs().maxCoeff() > kFarthest)
    return refused("a pose that is no place; three numbers within {} m are expected", kFarthest);
  if (!(std::abs(q.norm() - 1.0) <= kUnitWithin))
    return refused("a pose whose quaternion has length {:.3g}; 1 is expected", q.norm());
  pose.pose.rotation = q.normalized();
  return pose;
}

std::string encode_pose(const TrackerPose& pose) {
  std::string payload;
  put(pose.sensor, payload);
  put(pose.sensor, payload);  // fills up; readers pass over it
  const auto& q = pose.pose.rotation;
  for (const double number : {pose.pose.translation.x(), pose.pose.translation.y(), pose.pose.translation.z(),
                              q.x(), q.y(), q.z(), q.w()})
    put(number, payload);
  return payload;
}

Expected<std::string> decode_name(std::string_view payload) {
  if (payload.size() < 5)
    return refused("a name without letters; one of 1 to {} is expected", kMostNameBytes);
  const std::uint32_t length = word_at(payload, 0);  // with the 0 that ends it
  if (length < 2 || length > payload.size() - 4)
    return refused("a name of {} bytes in {}; what fits is expected", length, payload.size() - 4);
  std::string_view name = payload.substr(4, length);
  name = name.substr(0, name.find('\0'));
  if (!is_name(name))
    return refused("a name that is none ('{}'); 1 to {} letters are expected", excerpt(name, 40),
                   kMostNameBytes);
  return std::string(name);
}

std::string encode_name(std::string_view name) {
  std::string payload;
  put(static_cast<std::uint32_t>(name.size() + 1), payload);
  payload += name;
  payload += '\0';
  return payload;
}

std::string tool_name(const std::string& device, std::int32_t sensor) {
  return sensor == 0 ? device : fmt::format("{}:{}", device, sensor);
}

}  // namespace palpate::drivers::vrpn
