// Text: commands, and replies without poses. Poses: codec_poses.cpp.
#include "drivers/ndi/codec.h"

#include <algorithm>

#include "drivers/ndi/internal/limits.h"
#include "palpate/core/text.h"

namespace palpate::drivers::ndi {
namespace {

constexpr std::size_t kHandleDigits = 2, kStatusDigits = 3, kSerialDigits = 8;
// Of PHINF 0001: what the tool is, its maker, its revision; its serial number; its status.
constexpr std::size_t kBeforeSerial = 23, kBasicLetters = 33;

bool is_printable(char c) { return c >= ' ' && c < 127; }
bool is_name_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); }

std::string_view without_blanks(std::string_view text) {
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.remove_suffix(1);
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  return text;
}

std::string with_checksum(std::string_view words) {
  return fmt::format("{}{:04X}\r", words, checksum(words));
}

}  // namespace

std::uint16_t checksum(std::string_view bytes) {
  std::uint16_t crc = 0;
  for (const char byte : bytes) {
    crc = static_cast<std::uint16_t>(crc ^ static_cast<unsigned char>(byte));
    for (int bit = 0; bit < 8; ++bit)
      crc = static_cast<std::uint16_t>((crc & 1) != 0 ? crc >> 1 ^ 0xa001 : crc >> 1);
  }
  return crc;
}

std::string encode_command(std::string_view words) { return with_checksum(words); }
std::string encode_text(std::string_view words) { return with_checksum(words); }
std::string encode_error(Code code) {
  return with_checksum(fmt::format("ERROR{:02X}", static_cast<unsigned>(code)));
}

std::string words_of(Code code) {
  switch (static_cast<int>(code)) {
    case 0x01:
      return "it does not know the command";
    case 0x02:
      return "the command is too long";
    case 0x03:
      return "the command is too short";
    case 0x04:
      return "the command's checksum is wrong";
    case 0x05:
      return "the command took too long";
    case 0x06:
      return "it cannot set up communication so";
    case 0x07:
      return "the command's parameters are wrong";
    case 0x08:
      return "there is no such handle";
    case 0x09:
      return "there is no such tracking priority";
    case 0x0a:
    case 0x0b:
      return "there is no such LED, or no such state of one";
    case 0x0c:
      return "not while it is in this mode";
    case 0x0d:
      return "no tool belongs to the handle";
    case 0x0e:
      return "the handle is not initialized";
    case 0x0f:
      return "the handle is not enabled";
    case 0x10:
      return "the system is not initialized";
    case 0x11:
      return "it cannot stop tracking";
    case 0x12:
      return "it cannot start tracking";
    case 0x13:
      return "it cannot initialize the tool";
    case 0x14:
      return "the sensor's or field generator's characterization is no good";
    case 0x15:
      return "it cannot initialize itself";
    case 0x16:
    case 0x17:
      return "it cannot start or stop its diagnosis";
    case 0x18:
    case 0x1b:
      return "it cannot tell what disturbs it from outside";
    case 0x19:
      return "it cannot read its firmware's version";
    case 0x1a:
      return "a fault within the device";
    case 0x1c:
      return "it cannot set up the markers' flashes";
    case 0x1d:
    case 0x1e:
    case 0x1f:
    case 0x20:
      return "it cannot read, write or select the tool's memory";
    case 0x21:
      return "it cannot test the tool's current";
    case 0x22:
      return "it has no camera parameters for the tool's wavelength";
    case 0x23:
      return "a parameter is out of range";
    case 0x24:
      return "there is no such measuring volume";
    case 0x25:
      return "it cannot tell its features";
    case 0x28:
    case 0x29:
      return "too many tools, or tools of this kind, for one frame";
    case 0x2a:
      return "it has no memory left";
    case 0x2b:
      return "the handle was not allocated";
    case 0x2c:
      return "nothing is plugged in at the handle any more";
    case 0x2d:
      return "all handles are in use";
    case 0x2e:
      return "its firmware versions do not fit each other";
    case 0x2f:
      return "there is no such port";
    case 0x30:
      return "the port has a handle already";
    case 0x31:
    case 0x32:
      return "this cannot be done with the tool of the handle";
    case 0x33:
      return "it does not have the feature";
    case 0x34:
    case 0x35:
    case 0x36:
    case 0x37:
    case 0x38:
      return "there is no such setting, or not with this value";
    case 0x39:
      return "it is not allowed: another program is its master, or the setting is fixed";
    case 0x3b:
      return "there is no such file on it";
    case 0x3c:
    case 0x3d:
      return "it cannot write or read its file";
    case 0x40:
      return "the tool's definition file is damaged or none";
    case 0x41:
      return "it cannot track tools of this make";
    case 0x42:
      return "a part of the device is not connected";
    case 0xf1:
      return "too much infrared light around it";
    case 0xf4:
    case 0xf5:
    case 0xf6:
      return "its flash memory fails";
    default:
      return "an error that its published guide does not tell";
  }
}

tl::expected<Command, Code> decode_command(std::string_view line) {
  if (line.size() > kMostCommand) return tl::unexpected(Code::too_long);
  const auto name_end = std::find_if_not(line.begin(), line.end(), is_name_letter);
  Command command;
  command.name = std::string(line.begin(), name_end);
  if (command.name.empty()) return tl::unexpected(Code::unknown_command);
  line.remove_prefix(command.name.size());
  if (line.empty()) return command;
  const char mark = line.front();
  line.remove_prefix(1);
  if (mark == ' ') {
    command.parameters = std::string(line);
    return command;
  }
  if (mark != ':') return tl::unexpected(Code::unknown_command);
  if (line.size() < kChecksumDigits) return tl::unexpected(Code::too_short);
  std::uint16_t said = 0;
  command.parameters = std::string(line.substr(0, line.size() - kChecksumDigits));
  if (!read_hex(line.substr(line.size() - kChecksumDigits), said) ||
      said != checksum(command.name + ':' + command.parameters))
    return tl::unexpected(Code::wrong_checksum);
  return command;
}

std::optional<Code> error_of(std::string_view words) {
  std::uint8_t number = 0;
  if (!words.starts_with("ERROR") || words.size() < 7 || !read_hex(words.substr(5, 2), number))
    return std::nullopt;
  return static_cast<Code>(number);
}

Expected<std::vector<Handle>> decode_handles(std::string_view words) {
  constexpr std::size_t kEach = kHandleDigits + kStatusDigits;
  std::uint8_t count = 0;
  if (!read_hex(words.substr(0, kHandleDigits), count) || words.size() != kHandleDigits + kEach * count)
    return refused("a list of handles '{}'; their number and {} digits for each are expected", excerpt(words),
                   kEach);
  std::vector<Handle> handles(count);
  words.remove_prefix(kHandleDigits);
  for (auto& handle : handles) {
    if (!read_hex(words.substr(0, kHandleDigits), handle.number) ||
        !read_hex(words.substr(kHandleDigits, kStatusDigits), handle.status))
      return refused("a handle '{}'; {} hexadecimal digits are expected", excerpt(words.substr(0, kEach)),
                     kEach);
    words.remove_prefix(kEach);
  }
  return handles;
}

std::string encode_handles(const std::vector<Handle>& handles) {
  std::string words = fmt::format("{:02X}", handles.size());
  for (const auto& handle : handles) words += fmt::format("{:02X}{:03X}", handle.number, handle.status);
  return words;
}

Expected<std::uint8_t> decode_handle(std::string_view words) {
  std::uint8_t handle = 0;
  if (words.size() != kHandleDigits || !read_hex(words, handle))
    return refused("a handle '{}'; two hexadecimal digits are expected", excerpt(words));
  return handle;
}

Expected<std::optional<ToolInfo>> decode_tool_info(std::string_view words) {
  if (words == "UNOCCUPIED") return std::nullopt;
  ToolInfo info;
  if (words.size() != kBasicLetters + kPartNumberBytes ||
      !std::all_of(words.begin(), words.end(), is_printable) ||
      !read_hex(words.substr(kBasicLetters - 2, 2), info.status))
    return refused("what a tool is '{}'; {} letters with its status are expected", excerpt(words, 60),
                   kBasicLetters + kPartNumberBytes);
  info.serial_number = std::string(without_blanks(words.substr(kBeforeSerial, kSerialDigits)));
  info.part_number = std::string(without_blanks(words.substr(kBasicLetters)));
  return info;
}

std::string encode_tool_info(const ToolInfo& info) {
  // A reference or probe (02) with one marker face and no buttons, of nobody in particular, first revision.
  return fmt::format("{:<8.8}{:<12.12}{:<3.3}{:>8.8}{:02X}{:<20.20}", "02000000", "PALPATE", "001",
                     info.serial_number, info.status, info.part_number);
}

}  // namespace palpate::drivers::ndi
