#include "palpate/calibration/session/board_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace palpate::calibration::session {
namespace {

// The board looks the same after half a turn, and the detector numbers its corners from either end. Our board
// has a dark square outside its first corner and a light one outside its last: that tells the two apart.
std::vector<device::Pixel> numbered(std::vector<device::Pixel> corners, const vision::BoardShape& shape,
                                    const std::vector<std::uint8_t>& grey, int width, int height) {
  const auto brightness = [&](const device::Pixel& p) -> double {
    const int u = static_cast<int>(std::lround(p.x())), v = static_cast<int>(std::lround(p.y()));
    double sum = 0.0;
    int count = 0;
    for (int dv = -1; dv <= 1; ++dv)
      for (int du = -1; du <= 1; ++du) {
        const int x = std::clamp(u + du, 0, width - 1), y = std::clamp(v + dv, 0, height - 1);
        sum +=
            grey[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
        ++count;
      }
    return sum / count;
  };
  const auto at = [&](int column, int row) {
    return corners[static_cast<std::size_t>(row * shape.columns + column)];
  };
  // Middle of the square diagonally outside a corner, by the step from the corner diagonally inside.
  const device::Pixel first = at(0, 0) + 0.5 * (at(0, 0) - at(1, 1));
  const device::Pixel last =
      at(shape.columns - 1, shape.rows - 1) +
      0.5 * (at(shape.columns - 1, shape.rows - 1) - at(shape.columns - 2, shape.rows - 2));
  if (brightness(first) > brightness(last)) std::reverse(corners.begin(), corners.end());
  return corners;
}

}  // namespace

std::optional<vision::BoardView> find_board(const device::CameraImage& image, const vision::BoardShape& shape,
                                            int half_window) {
  const auto grey = vision::grey_from_rgb(image.rgb);
  const auto corners = vision::find_board_corners(grey, image.width, image.height, shape, half_window);
  if (!corners) return std::nullopt;
  vision::BoardView view;
  view.name = fmt::format("image {}", image.frame);
  view.image = numbered(*corners, shape, grey, image.width, image.height);
  for (int i = 0; i < shape.corners(); ++i) view.board.push_back(shape.corner(i));
  return view;
}

Expected<BoardViewRecord> record_board_views(AcquisitionContext context, double seconds_long, int every) {
  const vision::BoardShape shape;
  BoardViewRecord seen;
  auto record = record_views(context, device::Gesture::look_around_board, seconds_long, every,
                             [&](const device::CameraImage& image) {
                               seen.width = image.width;
                               seen.height = image.height;
                               auto view = find_board(image, shape);
                               if (!view) return false;
                               seen.views.push_back(std::move(*view));
                               return true;
                             });
  if (!record) return tl::unexpected(record.error());
  seen.record = std::move(*record);
  return seen;
}

}  // namespace palpate::calibration::session
