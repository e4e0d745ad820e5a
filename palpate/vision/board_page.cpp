#include "palpate/vision/board_page.h"

#include <cmath>
#include <utility>

#include "palpate/core/text.h"
#include "palpate/core/units.h"

namespace palpate::vision {
namespace {

constexpr double kMargin = 0.010;  // m: printers leave so much white
constexpr double kLetters = 0.0032, kLineStep = 0.0044, kHairline = 0.0002, kTick = 0.0015;
constexpr double kWide = 0.25;  // a page that holds bar and words side by side

bool is_wide(const Paper& paper) { return paper.width >= kWide; }
// Below the squares, above the margin.
double for_words(const Paper& paper) { return is_wide(paper) ? 0.020 : 0.036; }
double words_y(const Paper& paper) { return paper.height - kMargin - for_words(paper) + 0.007; }

}  // namespace

Expected<Paper> paper_for(std::string_view name, int columns, int rows) {
  Paper paper{std::string(name), 0.0, 0.0};
  if (name == "a4")
    paper.width = 0.297, paper.height = 0.210;
  else if (name == "a3")
    paper.width = 0.420, paper.height = 0.297;
  else if (name == "letter")
    paper.width = 11 * 0.0254, paper.height = 8.5 * 0.0254;
  else
    return wrong_use("--paper '{}': a4, a3 or letter is expected", excerpt(name));
  if (rows > columns) std::swap(paper.width, paper.height);
  return paper;
}

double largest_square(const Paper& paper, int columns, int rows) {
  const double most =
      std::min((paper.width - 2 * kMargin) / columns, (paper.height - 2 * kMargin - for_words(paper)) / rows);
  return std::floor(most / 0.0005 + 1e-9) * 0.0005;
}

std::array<double, 2> board_on_page(const Paper& paper, const device::CharucoBoard& board) {
  const double left = 0.5 * (paper.width - board.columns * board.square);
  const double above =
      kMargin + 0.5 * (paper.height - 2 * kMargin - for_words(paper) - board.rows * board.square);
  return {left + board.square, above + board.square};
}

std::array<double, 2> bar_on_page(const Paper& paper, const device::CharucoBoard& board) {
  return {std::max(kMargin, board_on_page(paper, board)[0] - board.square), words_y(paper)};
}

Expected<PdfPage> board_page(const Paper& paper, const device::CharucoBoard& board, const MarkerBits& bits) {
  if (const auto fault = device::charuco_fault(board); !fault.empty()) return wrong_use("board: {}", fault);
  const double side = mm_from_metres(board.square);
  if (board.square > largest_square(paper, board.columns, board.rows) + 1e-9)
    return wrong_use(
        "board: {}x{} squares of {:g} mm do not fit {} paper; at most {:g} mm do, or take --paper a3",
        board.columns, board.rows, side, paper.name,
        mm_from_metres(largest_square(paper, board.columns, board.rows)));
  PdfPage page(paper.width, paper.height, "Palpate board");
  const auto origin = board_on_page(paper, board);
  for (int row = 0; row < board.rows; ++row)
    for (int column = 0; column < board.columns; ++column)
      if ((row + column) % 2 == 0)
        page.rectangle(origin[0] + (column - 1) * board.square, origin[1] + (row - 1) * board.square,
                       board.square, board.square);
  for (int id = 0; id < board.markers(); ++id) {
    const Vector3 corner = board.marker_corners(id)[0];
    const auto cells = bits(board.dictionary, id);
    const double cell = board.marker / static_cast<double>(cells.size());
    const double x = origin[0] + corner.x(), y = origin[1] + corner.y();
    page.rectangle(x, y, board.marker, board.marker);
    // White runs over black: no hairline between neighbours that a reader might draw.
    for (std::size_t r = 0; r < cells.size(); ++r)
      for (std::size_t c = 0; c < cells.size();) {
        std::size_t end = c;
        while (end < cells.size() && !cells[r][end]) ++end;
        if (end > c)
          page.rectangle(x + static_cast<double>(c) * cell, y + static_cast<double>(r) * cell,
                         static_cast<double>(end - c) * cell, cell, 1.0);
        c = std::max(end, c + 1);
      }
  }
  const auto bar = bar_on_page(paper, board);
  page.line(bar[0], bar[1], bar[0] + kScaleBar, bar[1], kHairline);
  for (int cm = 0; cm <= 10; ++cm) {
    const double x = bar[0] + 0.01 * cm, tick = cm % 5 == 0 ? 2 * kTick : kTick;
    page.line(x, bar[1] - tick, x, bar[1] + tick, kHairline);
  }
  page.text(bar[0], bar[1] + kLineStep + 2 * kTick, kLetters,
            "This bar is 100.0 mm long. Print at 100 %, do not fit to page.");
  const double x = is_wide(paper) ? bar[0] + kScaleBar + 0.008 : bar[0];
  double y = is_wide(paper) ? bar[1] - 0.002 : bar[1] + 2 * kLineStep + 2 * kTick;
  const auto say = [&](const std::string& words) {
    page.text(x, y, kLetters, words);
    y += kLineStep;
  };
  say(fmt::format("ChArUco board, {} x {} squares of {:g} mm, markers {:g} mm,", board.columns, board.rows,
                  side, mm_from_metres(board.marker)));
  say(fmt::format("dictionary {}, ids 0 to {}. This edge faces the camera.", board.dictionary,
                  board.markers() - 1));
  say(fmt::format("Measure all {} squares across: {:g} mm. If you find another length, give", board.columns,
                  side * board.columns));
  say(fmt::format("palpate rig webcam ... --square-mm (that length / {}).", board.columns));
  return page;
}

}  // namespace palpate::vision
