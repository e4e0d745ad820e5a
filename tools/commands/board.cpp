// palpate board: a calibration board to print, and the file that says what it is.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/vision/board_page.h"
#include "palpate/vision/charuco.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"

namespace palpate::tools::commands {
namespace {

struct BoardArguments {
  std::string out = "board.pdf", paper = "a4", squares = "7x5", dictionary = "4x4_50";
  double square_mm = 0.0;
  bool force = false;
};

constexpr double kMarkerShare = 0.74;  // of a square: large cells, and white enough around them

Expected<void> write_board(const BoardArguments& options) {
  device::CharucoBoard board;
  char rest = 0;
  if (std::sscanf(options.squares.c_str(), "%3dx%3d%c", &board.columns, &board.rows, &rest) != 2)
    return wrong_use("--squares '{}': COLUMNSxROWS is expected, such as 7x5", excerpt(options.squares));
  const auto paper = vision::paper_for(options.paper, board.columns, board.rows);
  if (!paper) return tl::unexpected(paper.error());
  board.dictionary = options.dictionary;
  if (board.columns < 2 || board.rows < 2)
    return wrong_use("--squares '{}': at least 3x3 are expected", excerpt(options.squares));
  board.square = options.square_mm > 0.0 ? metres_from_mm(options.square_mm)
                                         : vision::largest_square(*paper, board.columns, board.rows);
  board.marker = std::floor(kMarkerShare * board.square / 0.0005) * 0.0005;
  const auto page = vision::board_page(*paper, board, vision::charuco_bits);
  if (!page) return tl::unexpected(page.error());
  const std::filesystem::path pdf = options.out;
  if (pdf.extension() != ".pdf")
    return wrong_use("--out '{}': a file name that ends in .pdf is expected", excerpt(options.out));
  std::filesystem::path toml = pdf;
  toml.replace_extension(".toml");
  for (const auto& file : {pdf, toml})
    if (!options.force && is_there(file))
      return wrong_use("{}: exists already; choose another name, or --force to replace it", file.string());
  const std::string head =
      "# A ChArUco board as `palpate board` has drawn it. Where the print came out in another size: `palpate "
      "rig webcam\n# --square-mm` says so, or change square_mm and marker_mm here.\n";
  if (auto done = write_file(pdf, page->bytes()); !done) return done;
  if (auto done = write_file(toml, head + device::charuco_board_text(board)); !done) return done;
  print_line(fmt::format("{}  {}, {}x{} squares of {:g} mm, {} markers of {}", pdf.string(), paper->name,
                         board.columns, board.rows, mm_from_metres(board.square), board.markers(),
                         board.dictionary));
  print_line(toml.string() + "  the same for the program");
  return {};
}

}  // namespace

void add_board(CLI::App& program) {
  auto options = std::make_shared<BoardArguments>();
  auto* command = program.add_subcommand("board", "A calibration board (ChArUco) to print, as PDF");
  command->add_option("--out", options->out, "PDF file; a .toml beside it says what the board is")
      ->capture_default_str();
  command->add_option("--paper", options->paper, "a4, a3 or letter")->capture_default_str();
  command->add_option("--squares", options->squares, "Columns x rows of squares")
      ->type_name("7x5")
      ->capture_default_str();
  command
      ->add_option("--square-mm", options->square_mm,
                   "Side of a square; 0 = as large as the paper holds, in half millimetres")
      ->check(at_least_zero())
      ->default_val(0.0);
  command
      ->add_option("--dictionary", options->dictionary,
                   "Kind of the markers: 4x4_50 (readable from farthest) to 7x7_1000")
      ->capture_default_str();
  command->add_flag("--force", options->force, "Replace existing files");
  on(command, [options] { return write_board(*options); });
}

}  // namespace palpate::tools::commands
