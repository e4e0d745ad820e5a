// The page on which a ChArUco board is printed, with what a person needs to check the print.
//
// Metres on the page, from its upper left corner. Pure functions. A board that does not fit the page is wrong
// use.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/device/charuco_board.h"
#include "palpate/vision/pdf_page.h"

namespace palpate::vision {

struct Paper {
  std::string name;
  double width = 0.297, height = 0.210;  // m
};
// "a4", "a3", "letter": lying or standing, whichever suits the board. Wrong use: another word.
Expected<Paper> paper_for(std::string_view name, int columns, int rows);

// The largest square, in steps of half a millimetre, with which so many fit the paper beside margins and
// words, m.
double largest_square(const Paper& paper, int columns, int rows);

// Where the board's frame (its first inner corner) lies on the page.
std::array<double, 2> board_on_page(const Paper& paper, const device::CharucoBoard& board);

inline constexpr double kScaleBar = 0.100;  // m
// Of the scale bar's left end.
std::array<double, 2> bar_on_page(const Paper& paper, const device::CharucoBoard& board);

// A marker's bits with its border, true is black (palpate/vision/charuco.h).
using MarkerBits = std::function<std::vector<std::vector<bool>>(const std::string& dictionary, int id)>;
Expected<PdfPage> board_page(const Paper& paper, const device::CharucoBoard& board, const MarkerBits& bits);

}  // namespace palpate::vision
