// VRPN messages as bytes and as values: pure functions, no sockets.
//
// A connection begins with 24 bytes of version from both sides. Then come messages: a header of 24 bytes (length of header
// and payload, seconds, microseconds, sender, type, number; all big endian) and a payload that is filled up to a multiple
// of 8 bytes. Senders (devices) and types are numbers, which each side introduces by name in messages of negative type.
// Read: those introductions, tracker poses ("vrpn_Tracker Pos_Quat"), pings. Written: the same and pongs.
//
// Frames: a pose maps coordinates of the sensor to the frame that the server measures in. Metres and unit quaternions, as
// float64 on the wire. Stamps are the sender's clock, of microseconds. Every length is checked before use. Errors: refused,
// with what was expected. Source: the public library (github.com/vrpn/vrpn, vrpn_Connection, vrpn_Tracker), version 07.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/network/tool_sample.h"
#include "palpate/core/expected.h"

namespace palpate::drivers::vrpn {

inline constexpr std::size_t kCookieBytes = 24, kHeaderBytes = 24;
inline constexpr std::size_t kMostPayload = 1 << 20;  // bytes; larger, and the stream is not to be trusted
inline constexpr std::size_t kMostNameBytes = 100;    // of a device or a type

inline constexpr std::int32_t kSenderDescription = -1, kTypeDescription = -2, kDisconnect = -5;
inline constexpr const char* kPoseType = "vrpn_Tracker Pos_Quat";
inline constexpr const char* kPingType = "vrpn_Base ping_message";
inline constexpr const char* kPongType = "vrpn_Base pong_message";

std::string cookie();
// Refused: another protocol, or another major version.
Expected<void> check_cookie(std::string_view bytes);

struct Header {
  std::size_t payload_bytes = 0;
  Instant<TrackerClock> stamp;
  std::int32_t sender = 0, type = 0;
  // With what fills the payload up.
  std::size_t padded() const { return (payload_bytes + 7) / 8 * 8; }
};
struct Message {
  Instant<TrackerClock> stamp;
  std::int32_t sender = 0, type = 0;
  std::string payload;
};

// Of the first kHeaderBytes bytes. Refused: a length that no message has, a time that is none.
Expected<Header> decode_header(std::string_view bytes);
// Refused: a stamp outside 0 to 2^32 s.
Expected<std::string> encode(const Message& message);

struct TrackerPose {
  std::int32_t sensor = 0;
  network::RigidPose pose;
};
// Refused: another length, numbers that are no pose, a sensor below 0.
Expected<TrackerPose> decode_pose(std::string_view payload);
std::string encode_pose(const TrackerPose& pose);

// A name introduced under a number: of a device, or of a type. Refused: a length that does not fit, a name that is none.
Expected<std::string> decode_name(std::string_view payload);
std::string encode_name(std::string_view name);

// What a sensor of a device is called: the device's name, and ":2" behind it for all but the first.
std::string tool_name(const std::string& device, std::int32_t sensor);

}  // namespace palpate::drivers::vrpn
