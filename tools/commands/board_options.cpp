#include "tools/commands/board_options.h"

#include <cstdio>

#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/vision/charuco.h"
#include "tools/commands/checks.h"

namespace palpate::tools::commands {
namespace {

Expected<vision::BoardViews> read_views(const BoardOptions& options, const std::string& command) {
  if (options.images.empty() == options.corners.empty())
    return wrong_use("{}: exactly one of --images and --corners is expected", command);
  if (is_charuco(options)) {
    if (options.images.empty())
      return wrong_use("--board {}: a ChArUco board goes with --images; --corners has a chessboard's",
                       options.board);
    const auto board = device::read_charuco_board(options.board);
    if (!board) return tl::unexpected(board.error());
    return vision::read_charuco_images(options.images, *board);
  }
  const auto shape = vision::board_shape(options.board, metres_from_mm(options.square_mm));
  if (!shape) return tl::unexpected(shape.error());
  return options.images.empty() ? vision::read_board_corners(options.corners, *shape)
                                : vision::read_board_images(options.images, *shape, options.corner_window_px);
}

// The size of the camera's images where the corners' file does not tell it: the smallest usual one that holds
// them all.
bool usual_size(vision::BoardViews& views) {
  constexpr int kSizes[][2] = {{320, 240},   {640, 480},   {752, 480},   {800, 600},
                               {1024, 768},  {1280, 720},  {1280, 960},  {1280, 1024},
                               {1600, 1200}, {1920, 1080}, {2592, 1944}, {3840, 2160}};
  device::Pixel low(0, 0), high(0, 0);
  for (const auto& view : views.views)
    for (const auto& u : view.image) low = low.cwiseMin(u), high = high.cwiseMax(u);
  for (const auto& [width, height] : kSizes)
    if (low.minCoeff() > -0.5 && high.x() < width - 0.5 && high.y() < height - 0.5) {
      views.width = width, views.height = height;
      return true;
    }
  return false;
}

}  // namespace

void doubt_board(const BoardOptions& options, std::size_t pictures, int goes_on,
                 const vision::BoardShape& seen, std::vector<std::string>& warnings) {
  constexpr double kSmallest = 1.0;  // mm; squares of 5 to 200 mm would be 0.005 to 0.2 in metres
  if (is_charuco(options)) return;
  // By chance next to no picture looks so (board_continuation_test.cpp).
  if (goes_on > 0 && 3 * static_cast<std::size_t>(goes_on) >= pictures)
    warnings.push_back(
        fmt::format("the chessboard goes on beyond --board {} in {} of {}: count its inner corners again, "
                    "{}x{} or more are "
                    "expected",
                    options.board, goes_on, counted(pictures, "picture"), seen.columns, seen.rows));
  if (options.square_mm < kSmallest)
    warnings.push_back(fmt::format(
        "--square-mm {:g} looks like metres: millimetres are expected, {:g} for a square of {:g} m",
        options.square_mm, 1e3 * options.square_mm, options.square_mm));
}

bool is_charuco(const BoardOptions& options) { return options.board.ends_with(".toml"); }

std::string source_of(const BoardOptions& options) {
  return options.images.empty() ? options.corners : options.images;
}

Expected<vision::BoardViews> read_board_views(const BoardOptions& options, const std::string& command,
                                              std::vector<std::string>& warnings) {
  auto views = read_views(options, command);
  if (!views) return views;
  for (const auto& name : views->not_found)
    warnings.push_back(is_charuco(options)
                           ? fmt::format("fewer than 6 corners of the board in '{}'", name)
                           : fmt::format("no complete {} board in '{}'", options.board, name));
  if (views->views.empty() && is_charuco(options))
    return refused("{}: the board of {} is in none of the pictures; is it the one that was printed?",
                   source_of(options), options.board);
  if (views->views.empty())
    return refused("{}: no complete board of {} inner corners was found; check --board", source_of(options),
                   options.board);
  if (!views->doubt.empty()) warnings.push_back(views->doubt);
  doubt_board(options, views->views.size(), views->goes_on, views->seen_shape, warnings);
  return views;
}

Expected<void> set_size(const BoardOptions& options, vision::BoardViews& views,
                        std::vector<std::string>& warnings) {
  if (!options.size.empty()) {
    int width = 0, height = 0;
    char rest = 0;
    if (std::sscanf(options.size.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 2 ||
        height < 2 || width > 100000 || height > 100000)
      return wrong_use("--size-px '{}': WIDTHxHEIGHT is expected, such as 640x480", options.size);
    if (views.width != 0 && (views.width != width || views.height != height))
      return wrong_use("--size-px {}: the images are {}x{} px", options.size, views.width, views.height);
    views.width = width, views.height = height;
  }
  if (views.width == 0) {
    if (!usual_size(views))
      return wrong_use("{}: corners lie outside every usual image; give --size-px", options.corners);
    warnings.push_back(fmt::format(
        "the corners' file does not tell the image's size; {}x{} px is taken, else give --size-px",
        views.width, views.height));
  }
  for (const auto& view : views.views)
    for (const auto& u : view.image)
      if (u.x() < -0.5 || u.y() < -0.5 || u.x() > views.width - 0.5 || u.y() > views.height - 0.5)
        return wrong_use(
            "{}: view '{}': the corner at {:.1f}, {:.1f} px lies outside the image of {}x{} px, which ends "
            "at "
            "{:.1f}, {:.1f} (the first pixel's centre is 0, 0); correct it, or check --size-px",
            source_of(options), view.name, u.x(), u.y(), views.width, views.height, views.width - 0.5,
            views.height - 0.5);
  return {};
}

void add_board_options(CLI::App& command, BoardOptions& options) {
  command
      .add_option("--images", options.images,
                  "Photographs of the board, a quoted pattern such as 'left*.jpg'")
      ->type_name("GLOB");
  command.add_option("--corners", options.corners, "Corners found elsewhere, a CSV table")->type_name("FILE");
  command
      .add_option(
          "--board", options.board,
          "Of a chessboard its inner corners, columns x rows; of a ChArUco board the file that `palpate "
          "board` wrote")
      ->type_name("9x6|FILE.toml")
      ->capture_default_str();
  command.add_option("--square-mm", options.square_mm, "Side of a square")->capture_default_str();
  command.add_option("--size-px", options.size, "Size of the images, where --corners does not tell it")
      ->type_name("640x480");
  command
      .add_option("--corner-window-px", options.corner_window_px,
                  "Half the window in which a corner is refined; 0 = fitted to each view, better where "
                  "squares are small; default: 11, and 0 where that is too large for most views")
      ->check(between(0, 50));
}

}  // namespace palpate::tools::commands
