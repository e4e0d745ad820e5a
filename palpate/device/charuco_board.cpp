#include "palpate/device/charuco_board.h"

#include <algorithm>
#include <charconv>

#include "palpate/core/text.h"
#include "palpate/core/units.h"

namespace palpate::device {
namespace {

constexpr int kMostSquares = 60;  // along a side
constexpr NumberRange kSquares{2, kMostSquares}, kSideMm{1.0, 1000.0};

// The marker in a white square.
int marker_in(int columns, int column, int row) {
  int before = 0;
  for (int r = 0; r < row; ++r) before += r % 2 == 0 ? columns / 2 : (columns + 1) / 2;
  return before + (row % 2 == 0 ? (column - 1) / 2 : column / 2);
}

int in_dictionary(const std::string& name) {
  const auto at = name.find('_');
  int count = 0;
  if (at != std::string::npos) std::from_chars(name.data() + at + 1, name.data() + name.size(), count);
  return count;
}

}  // namespace

Vector3 CharucoBoard::corner(int i) const {
  const int along = columns - 1, row = i / along, column = i % along;
  return square * Vector3(column, row, 0.0);
}

std::array<Vector3, 4> CharucoBoard::marker_corners(int id) const {
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      if ((row + column) % 2 == 0 || marker_in(columns, column, row) != id) continue;
      const Vector3 at =
          square * Vector3(column - 1, row - 1, 0.0) + 0.5 * (square - marker) * Vector3(1.0, 1.0, 0.0);
      const Vector3 x(marker, 0.0, 0.0), y(0.0, marker, 0.0);
      return {at, at + x, at + x + y, at + y};
    }
  return {};
}

std::array<int, 2> CharucoBoard::markers_at(int i) const {
  // The four squares around it are (column, row) to (column + 1, row + 1).
  const int along = columns - 1, row = i / along, column = i % along;
  if ((row + column) % 2 == 0)
    return {marker_in(columns, column + 1, row), marker_in(columns, column, row + 1)};
  return {marker_in(columns, column, row), marker_in(columns, column + 1, row + 1)};
}

CharucoBoard CharucoBoard::printed_with(double measured_square) const {
  CharucoBoard board = *this;
  board.marker *= measured_square / square;
  board.square = measured_square;
  return board;
}

const std::vector<std::string>& charuco_dictionaries() {
  static const std::vector<std::string> names = {
      "4x4_50", "4x4_100", "4x4_250", "4x4_1000", "5x5_50", "5x5_100", "5x5_250", "5x5_1000",
      "6x6_50", "6x6_100", "6x6_250", "6x6_1000", "7x7_50", "7x7_100", "7x7_250", "7x7_1000"};
  return names;
}

std::string charuco_fault(const CharucoBoard& board) {
  const auto side = [](int n) { return n >= 2 && n <= kMostSquares; };
  if (!side(board.columns) || !side(board.rows) || board.columns * board.rows < 9)
    return fmt::format("{}x{} squares: 3x3 to {}x{} are expected", board.columns, board.rows, kMostSquares,
                       kMostSquares);
  if (!(board.square >= 1e-3 && board.square <= 1.0))
    return fmt::format("a square of {:g} mm: 1 to 1000 mm are expected", mm_from_metres(board.square));
  if (!(board.marker >= 0.3 * board.square && board.marker <= 0.9 * board.square))
    return fmt::format("a marker of {:g} mm in a square of {:g} mm: 0.3 to 0.9 of the square is expected",
                       mm_from_metres(board.marker), mm_from_metres(board.square));
  const auto& known = charuco_dictionaries();
  if (std::find(known.begin(), known.end(), board.dictionary) == known.end())
    return fmt::format("dictionary '{}': 4x4_50, 5x5_100, 6x6_250 or the like is expected",
                       excerpt(board.dictionary));
  if (board.markers() > in_dictionary(board.dictionary))
    return fmt::format(
        "{} white squares, but dictionary {} has {} markers; take a larger one, or fewer squares",
        board.markers(), board.dictionary, in_dictionary(board.dictionary));
  return {};
}

CharucoBoard charuco_board_of(const TomlTable& table) {
  CharucoBoard board;
  board.columns = static_cast<int>(table.integer("columns", kSquares));
  board.rows = static_cast<int>(table.integer("rows", kSquares));
  board.square = metres_from_mm(table.number("square_mm", kSideMm));
  board.marker = metres_from_mm(table.number("marker_mm", kSideMm));
  board.dictionary = table.choice("dictionary", charuco_dictionaries());
  if (table.has("columns") && table.has("rows") && table.has("square_mm") && table.has("marker_mm") &&
      table.has("dictionary"))
    if (const auto fault = charuco_fault(board); !fault.empty()) table.complain("columns", fault);
  return board;
}

std::string charuco_board_text(const CharucoBoard& board) {
  return fmt::format("columns = {}\nrows = {}\nsquare_mm = {}\nmarker_mm = {}\ndictionary = {}\n",
                     board.columns, board.rows, toml_number(mm_from_metres(board.square)),
                     toml_number(mm_from_metres(board.marker)), toml_quoted(board.dictionary));
}

Expected<CharucoBoard> read_charuco_board(const std::filesystem::path& path) {
  const auto file = read_toml(path);
  if (!file) return tl::unexpected(file.error());
  const CharucoBoard board = charuco_board_of(*file);
  if (const auto done = file->finish(); !done) return tl::unexpected(done.error());
  return board;
}

}  // namespace palpate::device
