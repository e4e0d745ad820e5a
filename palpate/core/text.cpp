#include "palpate/core/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <iterator>

namespace palpate::inline core {
namespace {

struct Codes {
  char32_t first, last;
};

constexpr Codes kControls[] = {
    {0x00, 0x1F},       {0x7F, 0x9F}, {0x061C, 0x061C},  // Arabic letter mark
    {0x180E, 0x180E},                                    // Mongolian vowel separator
    {0x200B, 0x200B},    // zero-width space; the joiners after it belong to words of some scripts
    {0x200E, 0x200F},    // left-to-right and right-to-left mark
    {0x2028, 0x202E},    // separators, embeddings and overrides
    {0x2060, 0x206F},    // invisible operators, isolates
    {0xFEFF, 0xFEFF},    // byte order mark
    {0xFFF9, 0xFFFB},    // annotations
    {0xE0000, 0xE007F},  // tags
};

std::size_t length_by_first_byte(unsigned char byte) {
  if (byte < 0x80) return 1;
  if (byte >= 0xC2 && byte < 0xE0) return 2;
  if (byte >= 0xE0 && byte < 0xF0) return 3;
  if (byte >= 0xF0 && byte < 0xF5) return 4;
  return 0;
}

template <typename Visit>
void for_each_character(std::string_view text, Visit visit) {
  while (!text.empty()) {
    const Character character = first_character(text);
    visit(character, text.substr(0, character.bytes));
    text.remove_prefix(character.bytes);
  }
}

}  // namespace

Character first_character(std::string_view text) {
  const auto byte = [text](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const Character none{.code = byte(0), .bytes = 1, .valid = false};
  const std::size_t length = length_by_first_byte(byte(0));
  if (length == 0 || length > text.size()) return none;
  if (length == 1) return {byte(0), 1, true};
  char32_t code = byte(0) & (0x7Fu >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return none;
    code = code << 6 | (byte(i) & 0x3Fu);
  }
  constexpr std::array<char32_t, 5> kLeast{0, 0, 0x80, 0x800, 0x10000};  // less has a shorter form
  if (code < kLeast[length] || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) return none;
  return {code, length, true};
}

bool is_control(char32_t code) {
  return std::any_of(std::begin(kControls), std::end(kControls),
                     [code](const Codes& range) { return code >= range.first && code <= range.last; });
}

bool has_control(std::string_view text) {
  bool found = false;
  for_each_character(text, [&found](const Character& character, std::string_view) {
    found = found || (character.valid && is_control(character.code));
  });
  return found;
}

bool is_plain(std::string_view text) {
  bool plain = true;
  for_each_character(text, [&plain](const Character& character, std::string_view) {
    plain = plain && character.valid && !is_control(character.code);
  });
  return plain;
}

std::string excerpt(std::string_view text, std::size_t most) {
  std::size_t length = std::min(text.size(), most);
  constexpr std::size_t kLongestTail = 3;  // bytes of a character after its first
  while (length < text.size() && length > 0 && most - length < kLongestTail &&
         (static_cast<unsigned char>(text[length]) & 0xC0) == 0x80)
    --length;
  std::string shown;
  for_each_character(text.substr(0, length), [&shown](const Character& character, std::string_view bytes) {
    shown += character.valid && !is_control(character.code) ? bytes : std::string_view("?");
  });
  return length < text.size() ? shown + "..." : shown;
}

std::string one_line(std::string_view text) { return excerpt(text, std::string_view::npos); }

std::string escaped_json(std::string_view json) {
  std::string escaped;
  escaped.reserve(json.size());
  for_each_character(json, [&escaped](const Character& character, std::string_view bytes) {
    if (!character.valid || character.code < 0x7F || !is_control(character.code))
      escaped += bytes;
    else if (character.code < 0x10000)
      escaped += fmt::format("\\u{:04x}", static_cast<std::uint32_t>(character.code));
    else  // as two halves of 10 bits
      escaped += fmt::format("\\u{:04x}\\u{:04x}", 0xD800 + ((character.code - 0x10000) >> 10),
                             0xDC00 + ((character.code - 0x10000) & 0x3FF));
  });
  return escaped;
}

}  // namespace palpate::inline core
