// Numbers as most binary files hold them: little-endian, wherever this runs. Any thread.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <string>

namespace palpate::inline core {

// The caller has seen that there are enough bytes.
template <typename Number>
Number little_endian(const char* at) {
  std::array<char, sizeof(Number)> bytes;
  std::memcpy(bytes.data(), at, bytes.size());
  if constexpr (std::endian::native == std::endian::big) std::reverse(bytes.begin(), bytes.end());
  return std::bit_cast<Number>(bytes);
}

template <typename Number>
void append_little_endian(std::string& bytes, Number value) {
  auto stored = std::bit_cast<std::array<char, sizeof(Number)>>(value);
  if constexpr (std::endian::native == std::endian::big) std::reverse(stored.begin(), stored.end());
  bytes.append(stored.data(), stored.size());
}

}  // namespace palpate::inline core
