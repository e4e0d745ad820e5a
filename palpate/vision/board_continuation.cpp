#include "palpate/vision/board_continuation.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace palpate::vision {
namespace {

constexpr int kFewestSquares = 4;      // seen of a line of squares: fewer look alike by chance
constexpr double kLeastContrast = 20;  // grey levels between neighbours of the outermost line
constexpr double kSameColour = 0.25;   // of that contrast, about the middle: neither black nor white

struct GreyImage {
  std::span<const std::uint8_t> grey;
  int width, height;

  // Mean of 3 x 3 pixels; nothing at the image's edge.
  std::optional<double> at(const device::Pixel& place) const {
    if (!(place.x() > 1.0 && place.y() > 1.0 && place.x() < width - 2.0 && place.y() < height - 2.0))
      return std::nullopt;
    const auto u = static_cast<std::size_t>(std::lround(place.x())),
               v = static_cast<std::size_t>(std::lround(place.y()));
    int sum = 0;
    for (std::size_t row = v - 1; row <= v + 1; ++row)
      for (std::size_t column = u - 1; column <= u + 1; ++column)
        sum += grey[row * static_cast<std::size_t>(width) + column];
    return sum / 9.0;
  }
};

// The board's corners as one of its sides sees them: line 0 is the outermost, `k` counts along it.
struct Side {
  const BoardShape& shape;
  const std::vector<device::Pixel>& corners;
  bool of_columns, from_end;

  int length() const { return of_columns ? shape.rows : shape.columns; }
  int depth() const { return of_columns ? shape.columns : shape.rows; }
  device::Pixel corner(int line, int k) const {
    const int across = from_end ? depth() - 1 - line : line;
    const int row = of_columns ? k : across, column = of_columns ? across : k;
    return corners[static_cast<std::size_t>(row * shape.columns + column)];
  }
  // The middle of square k, `out` lines outside line 0; between corners k and k + 1.
  device::Pixel middle(double out, int k) const {
    const double x = -out;
    const auto carried = [&](int at) -> device::Pixel {
      if (depth() < 3) return (1.0 - x) * corner(0, at) + x * corner(1, at);
      return 0.5 * (x - 1.0) * (x - 2.0) * corner(0, at) - x * (x - 2.0) * corner(1, at) +
             0.5 * x * (x - 1.0) * corner(2, at);
    };
    return 0.5 * (carried(k) + carried(k + 1));
  }
};

// Whether the squares beyond those at this side are coloured as a chessboard's are.
bool continues(const GreyImage& image, const Side& side) {
  double mean[2] = {0.0, 0.0};
  int count[2] = {0, 0};
  for (int k = 0; k + 1 < side.length(); ++k)
    if (const auto grey = image.at(side.middle(0.5, k))) mean[k % 2] += *grey, ++count[k % 2];
  if (count[0] == 0 || count[1] == 0) return false;
  mean[0] /= count[0], mean[1] /= count[1];
  const double contrast = std::abs(mean[0] - mean[1]), between = 0.5 * (mean[0] + mean[1]);
  if (contrast < kLeastContrast) return false;
  int seen = 0;
  for (int k = 0; k + 1 < side.length(); ++k) {
    const auto grey = image.at(side.middle(1.5, k));
    if (!grey) continue;
    const double towards_neighbour = (*grey - between) * (mean[(k + 1) % 2] > between ? 1.0 : -1.0);
    if (towards_neighbour < kSameColour * contrast) return false;
    ++seen;
  }
  return seen >= std::min(kFewestSquares, side.length() - 1) && seen >= 2;
}

}  // namespace

BoardContinuation board_continuation(std::span<const std::uint8_t> grey, int width, int height,
                                     const BoardShape& shape, const std::vector<device::Pixel>& corners) {
  BoardContinuation more;
  if (corners.size() != static_cast<std::size_t>(shape.corners()) ||
      grey.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
    return more;
  const GreyImage image{grey, width, height};
  for (const bool of_columns : {true, false})
    for (const bool from_end : {false, true})
      if (continues(image, Side{shape, corners, of_columns, from_end}))
        ++(of_columns ? more.columns : more.rows);
  return more;
}

}  // namespace palpate::vision
