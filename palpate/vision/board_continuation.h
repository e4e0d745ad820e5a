// Whether a chessboard goes on beyond the corners that were found on it: then it has more of them than was told, and
// the detector has taken a part of it for the whole, with residuals as small as of the right size.
//
// Looked at are the colours a little more than one square outside the outermost corners: on a board of the size told
// there is its margin, or the table. Their places are carried on from three lines of corners (Lagrange). On 13
// photographs of a 9x6 board (data/opencv_chessboard_left) it is told of all 13 with a column or a row left out at
// either end, and of none with all of them. Pixels as CameraModel has them. Pure function.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "palpate/vision/board.h"

namespace palpate::vision {

// At how many of two sides, at least, another column or row of squares follows.
struct BoardContinuation {
  int columns = 0, rows = 0;
};

// `corners` as find_board_corners gives them for this image and shape.
BoardContinuation board_continuation(std::span<const std::uint8_t> grey, int width, int height,
                                     const BoardShape& shape, const std::vector<device::Pixel>& corners);

}  // namespace palpate::vision
