// Binary PPM pictures (P6, 8 bits) as they come out of a pipe, cut from its bytes. One thread.
// Source of the format: netpbm, ppm(5).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace ppm {

struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

class Stream {
 public:
  static constexpr int kMostPixels = 64'000'000;

  void add(std::span<const char> bytes);
  // The next picture that is whole; none: more bytes are needed. Bytes that are no picture are passed over up to the
  // next "P6".
  std::optional<Picture> next();
  std::uint64_t damaged() const { return damaged_; }  // times something was passed over

 private:
  bool find_begin();
  std::string waiting_;
  bool in_step_ = true;
  std::uint64_t damaged_ = 0;
};

}  // namespace ppm
