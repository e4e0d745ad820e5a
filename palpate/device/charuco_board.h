// A ChArUco board: a chessboard whose white squares carry markers, so that each corner is known by itself and
// a board that is half covered, or half out of the picture, still tells where the camera is.
//
// Squares count from the upper left one, which is black; markers stand in the white squares, numbered row by
// row from 0. Board frame: first inner corner, x along a row to the right, y along the columns down, z into
// the sheet; metres. Source: Garrido-Jurado et al. (2014) for the markers; the layout is OpenCV's for an odd
// count of rows. Values and pure functions.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/toml.h"
#include "palpate/math/so3.h"

namespace palpate::device {

struct CharucoBoard {
  int columns = 7, rows = 5;              // squares
  double square = 0.035, marker = 0.026;  // sides, m
  std::string dictionary = "4x4_50";      // of charuco_dictionaries()

  int corners() const { return (columns - 1) * (rows - 1); }  // inner ones
  int markers() const { return columns * rows / 2; }
  Vector3 corner(int i) const;
  // Of the marker's black square: upper left, upper right, lower right, lower left.
  std::array<Vector3, 4> marker_corners(int id) const;
  // The markers in the two white squares that meet at an inner corner.
  std::array<int, 2> markers_at(int corner) const;
  // The middle of all squares.
  Vector3 middle() const { return {(0.5 * columns - 1.0) * square, (0.5 * rows - 1.0) * square, 0.0}; }
  // The same board where its squares were measured to be so large, m: printers scale.
  CharucoBoard printed_with(double measured_square) const;
};

// The usual sets of markers, bits along a side and how many: "4x4_50" to "7x7_1000".
const std::vector<std::string>& charuco_dictionaries();

// What keeps it from being a board, in words; empty: nothing does.
std::string charuco_fault(const CharucoBoard& board);

// Keys columns, rows, square_mm, marker_mm, dictionary of a table; a file that holds them alone.
CharucoBoard charuco_board_of(const TomlTable& table);
std::string charuco_board_text(const CharucoBoard& board);
Expected<CharucoBoard> read_charuco_board(const std::filesystem::path& path);

}  // namespace palpate::device
