// A small picture that is laid over another: panels, bars and words.
//
// Rows from the top, four bytes a pixel, red green blue and how much they cover, the colours already
// multiplied by the cover (so that 0 0 0 0 is nothing). Values; any thread.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

namespace palpate::desktop {

struct Colour {
  std::uint8_t red = 0, green = 0, blue = 0, cover = 255;
  bool operator==(const Colour&) const = default;
};

struct Canvas {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;

  Canvas() = default;
  Canvas(int wide, int high)
      : width(wide),
        height(high),
        rgba(static_cast<std::size_t>(wide) * static_cast<std::size_t>(high) * 4) {}

  // Lays a colour over a pixel, `share` of it in [0, 255]; beyond the edges nothing happens.
  void lay(int x, int y, const Colour& colour, int share = 255);
  void rectangle(int x, int y, int wide, int high, const Colour& colour);
  // With quarter circles of `radius` for corners.
  void rounded(int x, int y, int wide, int high, int radius, const Colour& colour);
  std::array<std::uint8_t, 4> at(int x, int y) const;
};

}  // namespace palpate::desktop
