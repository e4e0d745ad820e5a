// Messages of NDI's combined API as bytes and as values: pure functions, no sockets.
//
// A command is text: NAME:PARAMETERS, a checksum of four hexadecimal digits, CR; with a blank in the colon's place there is
// no checksum. A reply is text with a checksum and CR (OKAY, ERRORnn, values), or binary: 0xA5C4, length, checksum of these,
// body, checksum of the body, all little endian; 0xA5C8 where the length has 32 bits. BX replies with a state for each handle,
// BX2 with frames that have a time (General Binary Format: components of stated size, nested once).
//
// Frames: a pose maps coordinates of the tool to the frame that the device measures in. Millimetres and float32 on the wire,
// metres here. Stamps are the device's clock. Every length is checked before use. Errors: refused, with what was expected.
// Source: the maker's published guides (Polaris Application Program Interface Guide, IL-1070101; Polaris Vega Application
// Program Interface Guide, IL-1070259).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/network/tool_sample.h"
#include "palpate/core/expected.h"

namespace palpate::drivers::ndi {

// CRC-16, x^16 + x^15 + x^2 + 1 reflected, from 0.
std::uint16_t checksum(std::string_view bytes);

inline constexpr std::size_t kMostCommand = 1024;  // bytes without CR; a longer one is none

// `words` is NAME:PARAMETERS.
std::string encode_command(std::string_view words);

// What is wrong, by the API's numbers.
enum class Code : std::uint8_t {
  unknown_command = 0x01,
  too_long = 0x02,
  too_short = 0x03,
  wrong_checksum = 0x04,
  wrong_parameters = 0x07,
  no_such_handle = 0x08,
  no_such_priority = 0x09,
  not_in_this_mode = 0x0c,
  not_initialized = 0x0e,  // the handle
  system_not_initialized = 0x10,
  out_of_range = 0x23,
  handles_full = 0x2d,
  no_such_feature = 0x33,
  no_tool_definition = 0x40,
};
// In words, for a person.
std::string words_of(Code code);

struct Command {
  std::string name, parameters;
};
// Of a line without its CR. The code is what a device answers where it is no command.
tl::expected<Command, Code> decode_command(std::string_view line);

std::string encode_text(std::string_view words);
std::string encode_error(Code code);
// Refuses nothing: a body of 64 KiB and more has the longer header.
std::string encode_binary(std::string_view body);

// Of a reply of text without its checksum; none where it is no ERRORnn.
std::optional<Code> error_of(std::string_view words);

// What a device says about a handle, in PHSR, TX and BX.
namespace status {
inline constexpr std::uint32_t kOccupied = 0x01, kInitialized = 0x10, kEnabled = 0x20, kOutOfVolume = 0x40;
}
// The same in BX2: a code of eight bits and this one.
inline constexpr std::uint16_t kFrameMissing = 0x0100, kFrameOutOfVolume = 9;

struct Handle {
  std::uint8_t number = 0;
  std::uint16_t status = 0;
};
// Of PHSR. Refused: another length than its count says, digits that are none.
Expected<std::vector<Handle>> decode_handles(std::string_view words);
std::string encode_handles(const std::vector<Handle>& handles);
// Two hexadecimal digits, as PHRQ answers.
Expected<std::uint8_t> decode_handle(std::string_view words);

// Of PHINF with the options 0005.
struct ToolInfo {
  std::string serial_number;  // 8 hexadecimal digits
  std::string part_number;    // up to 20 letters, without the blanks that fill it up
  std::uint8_t status = 0;
};
inline constexpr std::size_t kPartNumberBytes = 20;
// Without a value: nothing is there (UNOCCUPIED). Refused: another length, letters that are none.
Expected<std::optional<ToolInfo>> decode_tool_info(std::string_view words);
std::string encode_tool_info(const ToolInfo& info);

struct Reading {
  enum class State : std::uint8_t { valid, missing, disabled };
  std::uint16_t handle = 0;
  State state = State::disabled;
  network::RigidPose pose;   // where valid
  std::uint32_t status = 0;  // of `status` in BX and TX, a code in BX2
  std::uint32_t frame = 0;   // of BX and TX
};

// Of a body of BX with the options 0001. Refused: what does not end where it should, a state that is none, numbers that are
// no pose.
Expected<std::vector<Reading>> decode_bx(std::string_view body);
std::string encode_bx(const std::vector<Reading>& readings);
// TX with the options 0001: text of fixed columns, hundredths of a millimetre. What does not fit them is missing.
std::string encode_tx(const std::vector<Reading>& readings);

struct Frame {
  Instant<TrackerClock> stamp;
  std::uint32_t number = 0;
  std::vector<Reading> tools;
};
// Of a body of BX2. Components other than frames and poses of tools are passed over. Refused as decode_bx() does.
Expected<std::vector<Frame>> decode_bx2(std::string_view body);
std::string encode_bx2(const std::vector<Frame>& frames);
// Bytes that a frame adds to it.
std::size_t bytes_of(const Frame& frame);

}  // namespace palpate::drivers::ndi
