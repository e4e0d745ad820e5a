// palpate rig webcam: the rig file of a desk with a printed board, a webcam and a mouse.
#include <cmath>
#include <cstdio>
#include <memory>

#include "palpate/core/file.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/rig/rig.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"

namespace palpate::tools::commands {
namespace {

struct WebcamArguments {
  std::string file, board, table = "750x1000";
  double square_mm = 0.0;
  bool force = false;
};

constexpr double kMostScaled = 0.2;  // a printer that scales more has printed something else

Expected<void> make_webcam_rig(const WebcamArguments& options) {
  auto board = device::read_charuco_board(options.board);
  if (!board) return tl::unexpected(board.error());
  const double drawn_mm = mm_from_metres(board->square);
  if (options.square_mm > 0.0) {
    if (std::abs(options.square_mm / drawn_mm - 1.0) > kMostScaled)
      return wrong_use(
          "--square-mm {:g}: a square of {} was drawn with {:g} mm, within {:.0f} % of it is "
          "expected; measure the whole row and divide by {}",
          options.square_mm, options.board, drawn_mm, 100.0 * kMostScaled, board->columns);
    board = board->printed_with(metres_from_mm(options.square_mm));
  }
  double width_mm = 0.0, length_mm = 0.0;
  char rest = 0;
  if (std::sscanf(options.table.c_str(), "%lfx%lf%c", &width_mm, &length_mm, &rest) != 2 ||
      !(width_mm >= 400.0 && width_mm <= 3000.0) || !(length_mm >= 600.0 && length_mm <= 3000.0))
    return wrong_use(
        "--table-mm '{}': WIDTHxLENGTH is expected, 400 to 3000 wide and 600 to 3000 long, such "
        "as 750x1000",
        excerpt(options.table));
  if (!options.force && is_there(options.file))
    return wrong_use("{}: exists already; choose another name, or --force to replace it", options.file);
  const rig::Rig rig = rig::desk_rig(*board, metres_from_mm(width_mm), metres_from_mm(length_mm));
  if (auto done = rig::write_rig(options.file, rig); !done) return done;
  fmt::print("{}  desk of {:g} x {:g} mm, board of {}x{} squares of {:g} mm\n", one_line(options.file),
             width_mm, length_mm, board->columns, board->rows, mm_from_metres(board->square));
  fmt::print(
      "next: palpate camera record CAMERA --out pictures --seconds 40 --every-s 1, the sheet seen from "
      "all sides; then\n      palpate calibrate camera --images 'pictures/*.png' --board {} --rig {}\n",
      one_line(options.board), one_line(options.file));
  return {};
}

}  // namespace

void add_rig_webcam(CLI::App& rig) {
  auto options = std::make_shared<WebcamArguments>();
  auto* command = rig.add_subcommand(
      "webcam", "Write the rig of a desk: a printed board tells a webcam its place, the mouse is the arm");
  command->add_option("FILE", options->file, "The rig file")->required();
  command->add_option("--board", options->board, "The file that `palpate board` wrote beside the PDF")
      ->required()
      ->type_name("FILE.toml");
  command
      ->add_option("--square-mm", options->square_mm,
                   "Side of a square as measured on the print; 0 = as it was drawn")
      ->check(at_least_zero())
      ->default_val(0.0);
  command->add_option("--table-mm", options->table, "Of the desk that is played on, width x length")
      ->type_name("750x1000")
      ->capture_default_str();
  command->add_flag("--force", options->force, "Replace an existing file");
  on(command, [options] { return make_webcam_rig(*options); });
}

}  // namespace palpate::tools::commands
