#include "palpate/desktop/canvas.h"

#include <algorithm>
#include <cmath>

namespace palpate::desktop {

void Canvas::lay(int x, int y, const Colour& colour, int share) {
  if (x < 0 || y < 0 || x >= width || y >= height) return;
  std::uint8_t* p = &rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                               static_cast<std::size_t>(x))];
  const int cover = (colour.cover * share + 127) / 255;
  if (cover == 255) {
    p[0] = colour.red, p[1] = colour.green, p[2] = colour.blue, p[3] = 255;
    return;
  }
  const std::array<int, 4> over{colour.red * cover / 255, colour.green * cover / 255,
                                colour.blue * cover / 255, cover};
  for (std::size_t i = 0; i < 4; ++i)
    p[i] = static_cast<std::uint8_t>(std::min(255, over[i] + p[i] * (255 - cover) / 255));
}

void Canvas::rectangle(int x, int y, int wide, int high, const Colour& colour) {
  for (int row = std::max(0, y); row < std::min(height, y + high); ++row)
    for (int column = std::max(0, x); column < std::min(width, x + wide); ++column) lay(column, row, colour);
}

void Canvas::rounded(int x, int y, int wide, int high, int radius, const Colour& colour) {
  radius = std::max(0, std::min({radius, wide / 2, high / 2}));
  rectangle(x, y + radius, wide, high - 2 * radius, colour);
  const int right = x + wide - 1, bottom = y + high - 1;
  for (const int row : {y, y + high - radius}) rectangle(x + radius, row, wide - 2 * radius, radius, colour);
  for (int row = 0; row < radius; ++row)
    for (int column = 0; column < radius; ++column) {
      // How far this pixel's centre lies within the corner's circle.
      const double inside = radius + 0.5 - std::hypot(radius - (column + 0.5), radius - (row + 0.5));
      if (inside <= 0.0) continue;
      const int share = static_cast<int>(255.0 * std::min(1.0, inside));
      for (const int across : {x + column, right - column})
        for (const int down : {y + row, bottom - row}) lay(across, down, colour, share);
    }
}

std::array<std::uint8_t, 4> Canvas::at(int x, int y) const {
  const std::size_t i =
      4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  return {rgba.at(i), rgba.at(i + 1), rgba.at(i + 2), rgba.at(i + 3)};
}

}  // namespace palpate::desktop
