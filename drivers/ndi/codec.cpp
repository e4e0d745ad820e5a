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

// Of a run of codes: its first, its last, what they mean.
struct Meaning {
  int first, last;
  const char* words;
};
constexpr Meaning kMeanings[] = {
    {0x01, 0x01, "it does not know the command"},
    {0x02, 0x02, "the command is too long"},
    {0x03, 0x03, "the command is too short"},
    {0x04, 0x04, "the command's checksum is wrong"},
    {0x05, 0x05, "the command took too long"},
    {0x06, 0x06, "it cannot set up communication so"},
    {0x07, 0x07, "the command's parameters are wrong"},
    {0x08, 0x08, "there is no such handle"},
    {0x09, 0x09, "there is no such tracking priority"},
    {0x0a, 0x0b, "there is no such LED, or no such state of one"},
    {0x0c, 0x0c, "not while it is in this mode"},
    {0x0d, 0x0d, "no tool belongs to the handle"},
    {0x0e, 0x0e, "the handle is not initialized"},
    {0x0f, 0x0f, "the handle is not enabled"},
    {0x10, 0x10, "the system is not initialized"},
    {0x11, 0x11, "it cannot stop tracking"},
    {0x12, 0x12, "it cannot start tracking"},
    {0x13, 0x13, "it cannot initialize the tool"},
    {0x14, 0x14, "the sensor's or field generator's characterization is no good"},
    {0x15, 0x15, "it cannot initialize itself"},
    {0x16, 0x17, "it cannot start or stop its diagnosis"},
    {0x18, 0x18, "it cannot tell what disturbs it from outside"},
    {0x19, 0x19, "it cannot read its firmware's version"},
    {0x1a, 0x1a, "a fault within the device"},
    {0x1b, 0x1b, "it cannot tell what disturbs it from outside"},
    {0x1c, 0x1c, "it cannot set up the markers' flashes"},
    {0x1d, 0x20, "it cannot read, write or select the tool's memory"},
    {0x21, 0x21, "it cannot test the tool's current"},
    {0x22, 0x22, "it has no camera parameters for the tool's wavelength"},
    {0x23, 0x23, "a parameter is out of range"},
    {0x24, 0x24, "there is no such measuring volume"},
    {0x25, 0x25, "it cannot tell its features"},
    {0x28, 0x29, "too many tools, or tools of this kind, for one frame"},
    {0x2a, 0x2a, "it has no memory left"},
    {0x2b, 0x2b, "the handle was not allocated"},
    {0x2c, 0x2c, "nothing is plugged in at the handle any more"},
    {0x2d, 0x2d, "all handles are in use"},
    {0x2e, 0x2e, "its firmware versions do not fit each other"},
    {0x2f, 0x2f, "there is no such port"},
    {0x30, 0x30, "the port has a handle already"},
    {0x31, 0x32, "this cannot be done with the tool of the handle"},
    {0x33, 0x33, "it does not have the feature"},
    {0x34, 0x38, "there is no such setting, or not with this value"},
    {0x39, 0x39, "it is not allowed: another program is its master, or the setting is fixed"},
    {0x3b, 0x3b, "there is no such file on it"},
    {0x3c, 0x3d, "it cannot write or read its file"},
    {0x40, 0x40, "the tool's definition file is damaged or none"},
    {0x41, 0x41, "it cannot track tools of this make"},
    {0x42, 0x42, "a part of the device is not connected"},
    {0xf1, 0xf1, "too much infrared light around it"},
    {0xf4, 0xf6, "its flash memory fails"},
};

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
  const int number = static_cast<int>(code);
  for (const auto& meaning : kMeanings)
    if (number >= meaning.first && number <= meaning.last) return meaning.words;
  return "an error that its published guide does not tell";
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
