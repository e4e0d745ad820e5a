// OpenIGTLink messages as bytes and as values: pure functions, no sockets.
//
// Read: TRANSFORM, TDATA, STATUS, STT_TDATA, STP_TDATA with header versions 1 to 3 (of later headers the
// extension and the metadata are passed over; "TransformStatus" in it is heeded). Written: TRANSFORM, TDATA,
// STATUS, STT_TDATA, STP_TDATA with header version 1, which every receiver understands.
//
// Frames: a pose maps coordinates of the tool to the frame that its name says ("StylusToTracker") or that the
// server measures in. Metres and unit quaternions here; millimetres and a column-order 3x4 matrix of float32
// on the wire, so that poses come back to about 1e-7 of their size. Stamps are the sender's clock, whatever
// it counts from. Every length is checked before use; nothing larger than kMostBodyBytes is ever kept.
// Errors: refused, with what was expected. Source: the protocol's specification (openigtlink.org/protocols,
// v1 to v3).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "drivers/network/tool_sample.h"
#include "palpate/core/expected.h"
#include "palpate/time/instant.h"

namespace palpate::drivers::openigtlink {

inline constexpr std::size_t kHeaderBytes = 58;
inline constexpr std::size_t kNameBytes = 20;           // of devices and tools; longer names are cut
inline constexpr std::size_t kMostBodyBytes = 1 << 20;  // 1 MiB: TDATA of 14 979 tools

// CRC-64 with the polynomial of ECMA-182, most significant bit first, from 0, not inverted.
std::uint64_t crc64(std::string_view bytes);

// 32.32 fixed point as on the wire. 0 is "no time" there; a stamp of exactly 0 is written as the next number.
std::optional<Instant<TrackerClock>> stamp_from_wire(std::uint64_t fixed);
// Refused below 0 and from 2^32 s on.
Expected<std::uint64_t> wire_from_stamp(std::optional<Instant<TrackerClock>> stamp);

struct Header {
  int version = 1;  // of the header: 1, 2 or 3
  std::string type, device;
  std::optional<Instant<TrackerClock>> stamp;
  std::uint64_t body_bytes = 0;
  std::uint64_t crc = 0;  // of the body
};

using network::RigidPose;

struct Transform {
  RigidPose pose;
  bool valid = true;  // false where the sender says that it did not see the tool: the pose is meaningless
};
struct Tool {
  std::string name;
  std::uint8_t type = 2;  // 1 tracker, 2 instrument with 6, 3 with 3, 4 with 5 degrees of freedom
  RigidPose pose;
};
struct TrackingData {
  std::vector<Tool> tools;
};
struct Status {
  std::uint16_t code = 1;  // 1: all is well
  std::int64_t subcode = 0;
  std::string name, text;
};
struct StartTracking {             // STT_TDATA: a client wants TDATA
  std::int32_t resolution_ms = 0;  // least time between two messages; 0 = as fast as possible
  std::string coordinates;
};
struct StopTracking {};  // STP_TDATA

using Content = std::variant<Transform, TrackingData, Status, StartTracking, StopTracking>;

struct Message {
  std::string device;
  std::optional<Instant<TrackerClock>> stamp;
  Content content;
};

// Of the first kHeaderBytes bytes. Refused: fewer bytes, a version or a type that no sender of this protocol
// writes; the stream is then not to be trusted any further.
Expected<Header> decode_header(std::string_view bytes);
// True for a kind that decode_body() reads.
bool is_known(const Header& header);
bool crc_agrees(const Header& header, std::string_view body);
// The body that belongs to a header of a known kind. Refused: wrong CRC, another length than said, lengths
// inside that do not fit, matrices that are no rigid motion.
Expected<Message> decode_body(const Header& header, std::string_view body);

// Header and body. Refused: numbers that are not finite, stamps outside the protocol's, bodies above
// kMostBodyBytes.
Expected<std::string> encode(const Message& message);

}  // namespace palpate::drivers::openigtlink
