#include "palpate/desktop/canvas.h"

#include <algorithm>
#include <cmath>

namespace palpate::desktop {

void Canvas::lay(int x, int y, const Colour& colour, int share) {
  if (x < 0 || y < 0 || x >= width || y >= height) return;
  std::uint8_t* p = &rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                               static_cast<std::size_t>(x))];
  const int cover = (colour.cover * share + 127) / 255;
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
  radius = std::min({radius, wide / 2, high / 2});
  for (int row = 0; row < high; ++row) {
    for (int column = 0; column < wide; ++column) {
      // How far this pixel's centre lies into a corner's square, beyond the centre of its circle.
      const double in_x = std::max({radius - (column + 0.5), column + 0.5 - (wide - radius), 0.0});
      const double in_y = std::max({radius - (row + 0.5), row + 0.5 - (high - radius), 0.0});
      const double inside = radius + 0.5 - std::hypot(in_x, in_y);
      if (inside <= 0.0) continue;
      lay(x + column, y + row, colour, static_cast<int>(255.0 * std::min(1.0, inside)));
    }
  }
}

std::array<std::uint8_t, 4> Canvas::at(int x, int y) const {
  const std::size_t i =
      4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  return {rgba.at(i), rgba.at(i + 1), rgba.at(i + 2), rgba.at(i + 3)};
}

}  // namespace palpate::desktop
