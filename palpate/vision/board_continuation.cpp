#include "palpate/vision/board_continuation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace palpate::vision {
namespace {

constexpr int kFewestSquares = 4;      // seen of a line of squares: fewer look alike by chance
constexpr double kLeastContrast = 20;  // grey levels between neighbours of the outermost line
constexpr double kLikeInside = 0.3;    // of that contrast: what is between neighbours further out
// Lines outside the outermost corners: beyond the edge of a board that ends there, and still within squares that its
// maker has cut in half.
constexpr double kBeyond = 1.25;

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

// Two kinds of squares in a line, every other one of a kind; of those in the picture.
struct Line {
  std::array<double, 2> mean{};
  std::array<int, 2> count{};
  std::vector<std::pair<int, double>> squares;  // which, and its grey

  Line(const GreyImage& image, const Side& side, double out) {
    for (int k = 0; k + 1 < side.length(); ++k)
      if (const auto grey = image.at(side.middle(out, k))) {
        squares.emplace_back(k, *grey);
        const auto kind = static_cast<std::size_t>(k % 2);
        mean[kind] += *grey, ++count[kind];
      }
    for (std::size_t kind : {0u, 1u}) mean[kind] /= std::max(1, count[kind]);
  }
  bool both() const { return count[0] > 0 && count[1] > 0; }
  double difference() const { return mean[0] - mean[1]; }
  bool alternates() const {
    const double middle = 0.5 * (mean[0] + mean[1]), sign = difference() > 0.0 ? 1.0 : -1.0;
    return std::all_of(squares.begin(), squares.end(), [&](const auto& square) {
      return sign * (square.second - middle) * (square.first % 2 == 0 ? 1.0 : -1.0) > 0.0;
    });
  }
};

// Whether the squares beyond those at this side are coloured as a chessboard's are.
bool continues(const GreyImage& image, const Side& side) {
  const Line outermost(image, side, 0.5), beyond(image, side, kBeyond);
  if (!outermost.both() || !beyond.both()) return false;
  if (static_cast<int>(beyond.squares.size()) < std::min(kFewestSquares, side.length() - 1)) return false;
  const double contrast = std::abs(outermost.difference());
  const double opposite = outermost.difference() > 0.0 ? -beyond.difference() : beyond.difference();
  return contrast > kLeastContrast && opposite > kLikeInside * contrast && beyond.alternates();
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
