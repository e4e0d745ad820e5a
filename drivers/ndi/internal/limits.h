// What both sides agree on, and digits.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <string_view>

namespace palpate::drivers::ndi {

inline constexpr double kFarthest = 1e4;             // m
inline constexpr std::size_t kBlockBytes = 64;       // of a tool's definition, in one command
inline constexpr std::size_t kChecksumDigits = 4;    // of text
inline constexpr std::size_t kPartNumberAt = 0x250;  // in a tool's definition

// Hexadecimal digits in capitals, all of them.
template <typename Number>
bool read_hex(std::string_view digits, Number& number) {
  const auto is_hex = [](char c) { return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'F'); };
  return !digits.empty() && std::all_of(digits.begin(), digits.end(), is_hex) &&
         std::from_chars(digits.data(), digits.data() + digits.size(), number, 16).ec == std::errc();
}

}  // namespace palpate::drivers::ndi
