#include "palpate/desktop/drawing.h"

#include <algorithm>
#include <cmath>

namespace palpate::desktop {
namespace {

constexpr double kLongest = 1e5;  // px: a line is cut there before it is drawn

// A range of whole pixels that holds [low, high], within [0, size).
struct PixelRange {
  int first = 0, end = 0;
  PixelRange(double low, double high, int size)
      : first(static_cast<int>(std::clamp(std::floor(low), 0.0, static_cast<double>(size)))),
        end(static_cast<int>(std::clamp(std::ceil(high), 0.0, static_cast<double>(size)))) {}
};

// How much of a pixel is covered whose centre lies `outside` an edge, in 255ths.
int cover_at(double outside) { return static_cast<int>(255.0 * std::clamp(0.5 - outside, 0.0, 1.0)); }

}  // namespace

void draw_line(Canvas& canvas, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width,
               const Colour& colour) {
  if (!from.allFinite() || !to.allFinite() || from.norm() > kLongest || to.norm() > kLongest) return;
  const Eigen::Vector2d along = to - from;
  const double length2 = along.squaredNorm(), half = 0.5 * width;
  const PixelRange rows(std::min(from.y(), to.y()) - half - 1.0, std::max(from.y(), to.y()) + half + 1.0,
                        canvas.height);
  for (int y = rows.first; y < rows.end; ++y) {
    double low = std::min(from.x(), to.x()), high = std::max(from.x(), to.x());
    double aside = half + 1.0;
    // Of a steep line a row meets only a short piece.
    if (std::abs(along.y()) > 1.0) {
      const double at = from.x() + (y + 0.5 - from.y()) * along.x() / along.y();
      aside *= std::sqrt(length2) / std::abs(along.y());
      low = std::max(low, at - aside), high = std::min(high, at + aside);
      aside = half + 1.0;
    }
    const PixelRange columns(low - aside, high + aside, canvas.width);
    for (int x = columns.first; x < columns.end; ++x) {
      const Eigen::Vector2d p = Eigen::Vector2d(x + 0.5, y + 0.5) - from;
      const double s = length2 > 0.0 ? std::clamp(p.dot(along) / length2, 0.0, 1.0) : 0.0;
      if (const int cover = cover_at((p - s * along).norm() - half); cover > 0)
        canvas.lay(x, y, colour, cover);
    }
  }
}

void draw_dashes(Canvas& canvas, const Eigen::Vector2d& from, const Eigen::Vector2d& to, double width,
                 double dash, const Colour& colour) {
  const double length = (to - from).norm();
  if (!(length > 0.0) || length > kLongest || !(dash > 0.0)) return;
  const Eigen::Vector2d way = (to - from) / length;
  for (double at = 0.0; at < length; at += 2.0 * dash)
    draw_line(canvas, from + at * way, from + std::min(length, at + dash) * way, width, colour);
}

void draw_disc(Canvas& canvas, const Eigen::Vector2d& centre, double radius, const Colour& colour) {
  draw_line(canvas, centre, centre, 2.0 * radius, colour);
}

void draw_ring(Canvas& canvas, const Eigen::Vector2d& centre, double radius, double width,
               const Colour& colour) {
  if (!centre.allFinite()) return;
  const double reach = radius + 0.5 * width + 1.0;
  const PixelRange rows(centre.y() - reach, centre.y() + reach, canvas.height),
      columns(centre.x() - reach, centre.x() + reach, canvas.width);
  for (int y = rows.first; y < rows.end; ++y)
    for (int x = columns.first; x < columns.end; ++x) {
      const double off = std::abs((Eigen::Vector2d(x + 0.5, y + 0.5) - centre).norm() - radius) - 0.5 * width;
      if (const int cover = cover_at(off); cover > 0) canvas.lay(x, y, colour, cover);
    }
}

void fill_polygon(Canvas& canvas, std::span<const Eigen::Vector2d> corners, const Colour& colour) {
  for (const auto& corner : corners)
    if (!corner.allFinite()) return;
  std::vector<double> crossings;
  for (int y = 0; y < canvas.height; ++y) {
    const double row = y + 0.5;
    crossings.clear();
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector2d &a = corners[i], &b = corners[(i + 1) % corners.size()];
      if ((a.y() <= row) == (b.y() <= row)) continue;
      crossings.push_back(a.x() + (row - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
    }
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2) {
      const PixelRange columns(crossings[i] + 0.5, crossings[i + 1] - 0.5, canvas.width);
      for (int x = columns.first; x < columns.end; ++x) canvas.lay(x, y, colour);
    }
  }
}

void draw_picture(Canvas& canvas, std::span<const std::uint8_t> rgb, Size picture, const Box& box) {
  if (box.width <= 0 || box.height <= 0 || picture.width <= 0 || picture.height <= 0) return;
  const auto wide = static_cast<std::size_t>(picture.width);
  if (rgb.size() < 3 * wide * static_cast<std::size_t>(picture.height)) return;
  // Between four pixels, by 256ths of them.
  struct Sample {
    std::size_t first, second;
    int share;
  };
  const auto sample = [](int at, int size, int of) {
    const double place = std::clamp((at + 0.5) / size * of - 0.5, 0.0, of - 1.0);
    const auto first = static_cast<std::size_t>(place);
    return Sample{first, std::min(first + 1, static_cast<std::size_t>(of) - 1),
                  static_cast<int>(256.0 * (place - static_cast<double>(first)))};
  };
  std::vector<Sample> columns;
  for (int x = 0; x < box.width; ++x) columns.push_back(sample(x, box.width, picture.width));
  for (int y = std::max(0, -box.y); y < box.height && box.y + y < canvas.height; ++y) {
    const Sample row = sample(y, box.height, picture.height);
    const std::uint8_t *above = &rgb[3 * wide * row.first], *below = &rgb[3 * wide * row.second];
    std::uint8_t* to =
        &canvas.rgba[4 * static_cast<std::size_t>(box.y + y) * static_cast<std::size_t>(canvas.width)];
    for (int x = std::max(0, -box.x); x < box.width && box.x + x < canvas.width; ++x) {
      const Sample& column = columns[static_cast<std::size_t>(x)];
      std::uint8_t* pixel = to + 4 * static_cast<std::size_t>(box.x + x);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t a = 3 * column.first + k, b = 3 * column.second + k;
        const int upper = above[a] * (256 - column.share) + above[b] * column.share,
                  lower = below[a] * (256 - column.share) + below[b] * column.share;
        pixel[k] = static_cast<std::uint8_t>((upper * (256 - row.share) + lower * row.share) >> 16);
      }
      pixel[3] = 255;
    }
  }
}

void put(Canvas& canvas, const Canvas& piece, int x, int y) {
  for (int row = std::max(0, -y); row < piece.height && y + row < canvas.height; ++row)
    for (int column = std::max(0, -x); column < piece.width && x + column < canvas.width; ++column) {
      const std::uint8_t* from =
          &piece.rgba[4 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(piece.width) +
                           static_cast<std::size_t>(column))];
      if (from[3] == 0) continue;
      std::uint8_t* to =
          &canvas.rgba[4 * (static_cast<std::size_t>(y + row) * static_cast<std::size_t>(canvas.width) +
                            static_cast<std::size_t>(x + column))];
      if (from[3] == 255) {
        std::copy_n(from, 4, to);
        continue;
      }
      for (std::size_t k = 0; k < 4; ++k)
        to[k] = static_cast<std::uint8_t>(std::min(255, from[k] + to[k] * (255 - from[3]) / 255));
    }
}

void to_rgb(const Canvas& canvas, std::vector<std::uint8_t>& rgb) {
  const std::size_t pixels = canvas.rgba.size() / 4;
  rgb.resize(3 * pixels);
  for (std::size_t i = 0; i < pixels; ++i)
    for (std::size_t k = 0; k < 3; ++k) rgb[3 * i + k] = canvas.rgba[4 * i + k];
}

}  // namespace palpate::desktop
