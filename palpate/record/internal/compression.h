// Zstandard, in memory. One thread per object.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace palpate::record {

class Compressor {
 public:
  Compressor();
  ~Compressor();
  Compressor(Compressor&&) noexcept;
  Compressor& operator=(Compressor&&) noexcept;
  // Level 1: higher ones buy three per cent of the size for many times the work. Valid until the next call.
  std::string_view compress(std::string_view bytes);

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

class Decompressor {
 public:
  Decompressor();
  ~Decompressor();
  Decompressor(Decompressor&&) noexcept;
  Decompressor& operator=(Decompressor&&) noexcept;
  // Exactly `size` bytes, or nothing where `bytes` are no Zstandard data or hold another number. The caller bounds `size`;
  // memory is used as far as the data really fills it. Valid until the next call.
  std::optional<std::string_view> decompress(std::string_view bytes, std::uint64_t size);

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

}  // namespace palpate::record
