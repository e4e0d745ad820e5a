// Options of the commands that take views of a board, and the views they name.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/vision/board.h"

namespace palpate::tools::commands {

struct BoardOptions {
  std::string images, corners, board = "9x6", size;
  double square_mm = 25.0;
  std::optional<int> corner_window_px;  // vision::read_board_images
};

void add_board_options(CLI::App& command, BoardOptions& options);

bool is_charuco(const BoardOptions& options);
// The option's value that the views come from.
std::string source_of(const BoardOptions& options);

// At least one view; images without the board are named in `warnings`. `command` is named where it is asked for no
// views, or for two kinds.
Expected<vision::BoardViews> read_board_views(const BoardOptions& options, const std::string& command,
                                              std::vector<std::string>& warnings);

// Warns of a chessboard that goes on, in `goes_on` of the pictures it was found in, beyond the corners told, up to
// `seen` at least, and of squares that look like metres: the fit itself is as good as with the right ones.
void doubt_board(const BoardOptions& options, std::size_t pictures, int goes_on,
                 const vision::BoardShape& seen, std::vector<std::string>& warnings);

// The size of the images, as the views or --size-px tell it, else the smallest usual one; corners outside are wrong
// use.
Expected<void> set_size(const BoardOptions& options, vision::BoardViews& views,
                        std::vector<std::string>& warnings);

}  // namespace palpate::tools::commands
