// Chessboards: where their inner corners are in an image, in a set of image files or in a table of corners.
//
// Pixels as CameraModel has them: (0,0) is the centre of the first pixel. Board frame: origin at the first
// inner corner, x along a row of corners (columns), y along the rows, metres. Functions without state, safe
// from any thread. A board that is not seen is no error but an absent value; unreadable or contradictory
// files are wrong use. Source: OpenCV's chessboard detector and its sub-pixel refinement (Foerstner & Guelch
// 1987).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/device/camera_model.h"

namespace palpate::vision {

// Half of the window in which a corner is refined, px: as OpenCV's own calibration program has it.
constexpr int kUsualHalfWindow = 11;

struct BoardShape {
  int columns = 9, rows = 6;  // inner corners
  double square = 0.025;      // m

  int corners() const { return columns * rows; }
  Vector3 corner(int i) const {
    const int row = i / columns, column = i % columns;
    return square * Vector3(column, row, 0);
  }
};

// "9x6" and the side of a square in metres.
Expected<BoardShape> board_shape(const std::string& text, double square);

struct BoardView {
  std::string name;                  // image it came from
  std::vector<Vector3> board;        // corners in Board, m
  std::vector<device::Pixel> image;  // the same corners in the camera's image
};

struct BoardViews {
  std::vector<BoardView> views;
  int width = 0, height = 0;           // of the images, px; 0 where the source does not tell
  std::vector<std::string> not_found;  // images without a complete board
  // Images of a chessboard in which squares go on beyond the corners (board_continuation.h), and a size that holds
  // what was seen of it.
  int goes_on = 0;
  BoardShape seen_shape{};
  // A warning: squares are too small for the usual window in most views; empty: they are not.
  std::string doubt;
  std::string data_hash;  // of the files
};

// All inner corners of the board in a grey image (row 0 on top, no gaps between rows), in the board's order,
// or none. Boards with one odd and one even count of corners (9x6) are numbered the same way from every
// side; others are not, and do for a lens but not for a hand-eye calibration. `half_window` px around each
// corner are used to refine it; 0 = as much as fits between neighbours in this view.
std::optional<std::vector<device::Pixel>> find_board_corners(std::span<const std::uint8_t> grey, int width,
                                                             int height, const BoardShape& shape,
                                                             int half_window = 0);

// Luminance of an RGB image, 3 bytes a pixel.
std::vector<std::uint8_t> grey_from_rgb(std::span<const std::uint8_t> rgb);

// Every image file the pattern (shell wildcards, one argument) names, in name order. `half_window` as above; none = the
// usual one, or one fitted to each view where the usual one is more than fits in most. Files are searched longer than a
// camera's pictures one after another: small boards in cluttered pictures are found, and one without a board takes a
// second or two; noise is left at once.
Expected<BoardViews> read_board_images(const std::string& pattern, const BoardShape& shape,
                                       std::optional<int> half_window = {});

// The same with a finder of one's own: the board in a grey image, none where it is not there.
using FindBoard = std::function<std::optional<BoardView>(std::span<const std::uint8_t> grey, int width,
                                                         int height, const std::string& name)>;
Expected<BoardViews> read_views_of_images(const std::string& pattern, const FindBoard& find);

// Table with columns image, corner, board_x_squares, board_y_squares, u_px, v_px and, optionally, width_px,
// height_px.
Expected<BoardViews> read_board_corners(const std::string& file, const BoardShape& shape);
Expected<BoardViews> parse_board_corners(std::string_view content, const std::string& source,
                                         const BoardShape& shape);

}  // namespace palpate::vision
