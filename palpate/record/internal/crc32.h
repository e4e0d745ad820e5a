// The CRC-32 of zlib, PNG and MCAP (reflected polynomial 0xEDB88320), eight bytes a step. Any thread.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "palpate/core/little_endian.h"

namespace palpate::record {

// Goes on from the CRC of what came before; 0: from the beginning.
inline std::uint32_t crc32(std::string_view bytes, std::uint32_t before = 0) {
  using Tables = std::array<std::array<std::uint32_t, 256>, 8>;
  static constexpr Tables kTables = [] {
    Tables tables{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t value = i;
      for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1u) != 0 ? 0xEDB88320u : 0u);
      tables[0][i] = value;
    }
    for (std::size_t k = 1; k < 8; ++k)
      for (std::size_t i = 0; i < 256; ++i)
        tables[k][i] = (tables[k - 1][i] >> 8) ^ tables[0][tables[k - 1][i] & 0xFFu];
    return tables;
  }();
  std::uint32_t crc = ~before;
  for (; bytes.size() >= 8; bytes.remove_prefix(8)) {
    const std::uint32_t low = little_endian<std::uint32_t>(bytes.data()) ^ crc;
    const std::uint32_t high = little_endian<std::uint32_t>(bytes.data() + 4);
    crc = kTables[7][low & 0xFFu] ^ kTables[6][(low >> 8) & 0xFFu] ^ kTables[5][(low >> 16) & 0xFFu] ^
          kTables[4][low >> 24] ^ kTables[3][high & 0xFFu] ^ kTables[2][(high >> 8) & 0xFFu] ^
          kTables[1][(high >> 16) & 0xFFu] ^ kTables[0][high >> 24];
  }
  for (const char c : bytes) crc = (crc >> 8) ^ kTables[0][(crc ^ static_cast<unsigned char>(c)) & 0xFFu];
  return ~crc;
}

}  // namespace palpate::record
