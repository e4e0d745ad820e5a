#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>

#include "palpate/calibration/session/board_views.h"
#include "palpate/calibration/session/sample_csv.h"
#include "palpate/calibration/session/stream_tables.h"
#include "palpate/core/csv.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/charuco_board.h"
#include "palpate/vision/board_continuation.h"
#include "palpate/vision/camera.h"
#include "palpate/vision/charuco.h"
#include "tools/commands/board_options.h"
#include "tools/commands/command.h"
#include "tools/commands/lens_file.h"
#include "tools/commands/sample_kinds.h"
#include "tools/commands/sample_source.h"

namespace palpate::tools::commands {
namespace {

namespace session = calibration::session;

struct BoardSampling {
  SampleArguments source;
  BoardOptions board;
  std::string stamps, lens;
};

// Views of the board with the moments they were taken at; nothing where nobody tells.
struct TimedViews {
  std::vector<vision::BoardView> views;
  std::vector<std::optional<double>> time_s;
  std::size_t pictures = 0;
};

// How a board is found in a camera's picture, by --board.
using FindInPicture = std::function<std::optional<vision::BoardView>(const device::CameraImage&)>;
Expected<FindInPicture> finder_of(const BoardOptions& options) {
  if (is_charuco(options)) {
    const auto board = device::read_charuco_board(options.board);
    if (!board) return tl::unexpected(board.error());
    return [board = *board](const device::CameraImage& image) -> std::optional<vision::BoardView> {
      constexpr std::size_t kFewest = 6;
      const auto sight =
          vision::find_charuco(vision::grey_from_rgb(image.rgb), image.width, image.height, board);
      if (sight.corners.size() < kFewest) return std::nullopt;
      return vision::charuco_view(board, sight, "");
    };
  }
  const auto shape = vision::board_shape(options.board, metres_from_mm(options.square_mm));
  if (!shape) return tl::unexpected(shape.error());
  return [shape = *shape, window = options.corner_window_px.value_or(vision::kUsualHalfWindow)](
             const device::CameraImage& image) { return session::find_board(image, shape, window); };
}

// Names of images without their folder.
std::string bare_name(const std::string& path) { return std::filesystem::path(path).filename().string(); }

Expected<std::map<std::string, double>> read_stamps(const std::string& file) {
  std::map<std::string, double> stamps;
  if (file.empty()) return stamps;
  const auto table = read_csv(file);
  if (!table) return tl::unexpected(table.error());
  const auto image = table->require("image"), time = table->require("time_s");
  if (!image) return tl::unexpected(image.error());
  if (!time) return tl::unexpected(time.error());
  for (std::size_t i = 0; i < table->rows.size(); ++i)
    stamps[bare_name(table->text[i][*image])] = table->rows[i][*time];
  return stamps;
}

Expected<TimedViews> views_of_images(const BoardSampling& options, TakenSamples& taken) {
  auto read = read_board_views(options.board, "sample board", taken.warnings);
  if (!read) return tl::unexpected(read.error());
  const auto stamps = read_stamps(options.stamps);
  if (!stamps) return tl::unexpected(stamps.error());
  taken.source = options.board.images;
  TimedViews timed;
  timed.pictures = read->views.size() + read->not_found.size();
  std::size_t without = 0;
  for (auto& view : read->views) {
    const auto at = stamps->find(bare_name(view.name));
    without += at == stamps->end() ? 1 : 0;
    timed.time_s.push_back(at == stamps->end() ? std::nullopt : std::optional(at->second));
    timed.views.push_back(std::move(view));
  }
  if (!options.stamps.empty() && without > 0)
    taken.warnings.push_back(
        fmt::format("{} without a stamp in {}", counted(without, "view"), options.stamps));
  return timed;
}

Expected<TimedViews> views_of_camera(const BoardSampling& options, TakenSamples& taken) {
  auto find = finder_of(options.board);
  if (!find) return tl::unexpected(find.error());
  TimedViews timed;
  std::vector<Instant<CameraClock>> stamps;
  const auto shape = vision::board_shape(options.board.board, 1.0);  // none of a ChArUco board
  int goes_on = 0;
  vision::BoardShape seen{0, 0, 1.0};
  SampleNeeds needs{.camera = true};
  needs.picture = [&](const device::CameraImage& image) {
    ++timed.pictures;
    auto view = (*find)(image);
    if (!view) return;
    if (shape) {
      const auto more = vision::board_continuation(vision::grey_from_rgb(image.rgb), image.width,
                                                   image.height, *shape, view->image);
      goes_on += more.columns + more.rows > 0 ? 1 : 0;
      seen.columns = std::max(seen.columns, shape->columns + more.columns);
      seen.rows = std::max(seen.rows, shape->rows + more.rows);
    }
    view->name = fmt::format("image_{}", image.frame);
    timed.views.push_back(std::move(*view));
    stamps.push_back(image.mid_exposure);
  };
  needs.progress = [&] { return fmt::format("board in {} of {}", timed.views.size(), timed.pictures); };
  auto result = take_samples(options.source, needs);
  if (!result) return tl::unexpected(result.error());
  taken = std::move(*result);
  if (timed.pictures == 0) return refused("{}: no picture came", taken.source);
  if (timed.views.empty())
    return refused("{}: the board {} was in none of {}; all of it has to be in view, in good light",
                   taken.source, options.board.board, counted(timed.pictures, "picture"));
  doubt_board(options.board, timed.views.size(), goes_on, seen, taken.warnings);
  for (const auto& stamp : stamps) timed.time_s.emplace_back(taken.streams.host_time(stamp));
  return timed;
}

bool any_stamp(const TimedViews& timed) {
  return std::any_of(timed.time_s.begin(), timed.time_s.end(),
                     [](const auto& time) { return time.has_value(); });
}

// The camera at the board in each view that tells it; the others are counted.
std::vector<session::BoardSight> sights_of(const TimedViews& timed, const device::CameraModel& lens,
                                           TakenSamples& taken, Json& counts) {
  std::vector<session::BoardSight> sights;
  std::size_t ambiguous = 0, misfit = 0;
  double square = 0.0;
  const bool stamped = any_stamp(timed);
  for (std::size_t i = 0; i < timed.views.size(); ++i) {
    if (stamped && !timed.time_s[i]) continue;  // times and numbers do not mix
    const auto pose = vision::board_pose(lens, timed.views[i]);
    misfit += pose ? 0 : 1;
    ambiguous += pose && pose->value.ambiguous ? 1 : 0;
    if (!pose || pose->value.ambiguous) continue;
    sights.push_back({timed.time_s[i].value_or(static_cast<double>(sights.size())), timed.views[i].name,
                      pose->value.X_camera_board.inverse(), pose->value.rms_px});
    square += pose->value.rms_px * pose->value.rms_px;
  }
  if (ambiguous > 0)
    taken.warnings.push_back(
        fmt::format("{} left out: the board could be tilted either way", counted(ambiguous, "view")));
  if (misfit > 0)
    taken.warnings.push_back(
        fmt::format("{} left out: corners that do not fit this lens and board", counted(misfit, "view")));
  counts["poses"] = sights.size();
  counts["ambiguous"] = ambiguous;
  counts["misfit"] = misfit;
  if (!sights.empty()) counts["rms_px"] = std::sqrt(square / static_cast<double>(sights.size()));
  return sights;
}

std::string stamps_csv(const TimedViews& timed) {
  CsvWriter csv({"image", "time_s"});
  for (std::size_t i = 0; i < timed.views.size(); ++i)
    if (timed.time_s[i])
      csv.row(std::vector<std::string>{timed.views[i].name, number_text(*timed.time_s[i])});
  return csv.content();
}

Expected<void> sample_board_tables(const BoardSampling& options) {
  const auto rig = rig_of_samples(options.source);
  if (!rig) return tl::unexpected(rig.error());
  const auto lens = given_lens(options.lens, *rig, options.source.which_camera);
  if (!lens) return tl::unexpected(lens.error());
  const bool images = !options.board.images.empty();
  if (images && (!options.source.recording.empty() || !options.source.camera.empty()))
    return wrong_use("--images {}: goes without --camera and --recording", options.board.images);
  if (!images && !options.stamps.empty()) return wrong_use("--stamps {}: goes with --images", options.stamps);
  TakenSamples taken;
  auto timed = images ? views_of_images(options, taken) : views_of_camera(options, taken);
  if (!timed) return tl::unexpected(timed.error());
  Json counts{{"pictures", timed->pictures}, {"views", timed->views.size()}};
  std::vector<SampleTable> tables;
  const double square = is_charuco(options.board) ? 1e-3 : metres_from_mm(options.board.square_mm);
  const std::string out = one_line(options.source.out);
  std::string next;
  if (!is_charuco(options.board)) {
    std::size_t corners = 0;
    for (const auto& view : timed->views) corners += view.image.size();
    tables.push_back({"corners.csv", session::corners_csv(timed->views, square), corners});
    next = fmt::format(
        "palpate calibrate camera --corners {}/corners.csv --board {} --square-mm {:g} --rig FILE", out,
        options.board.board, options.board.square_mm);
  }
  if (any_stamp(*timed)) tables.push_back({"stamps.csv", stamps_csv(*timed), timed->views.size()});
  if (!*lens) {
    taken.warnings.emplace_back(
        "no lens is known (--lens, or --rig after calibrate camera): corners alone, no poses");
    if (tables.empty())
      return refused("{}: poses of a ChArUco board need a lens: --lens FILE or --rig FILE", taken.source);
    return write_samples(options.source, "board", taken, tables, counts, next);
  }
  const auto sights = sights_of(*timed, **lens, taken, counts);
  if (sights.empty())
    return refused("{}: none of {} fits this lens and board; check --board, --square-mm and --lens",
                   taken.source, counted(timed->views.size(), "view"));
  if (images && options.stamps.empty())
    taken.warnings.emplace_back(
        "nobody tells when the images were taken (--stamps): their times are their numbers");
  tables.push_back({"eye.csv", session::sights_csv(sights), sights.size()});
  const auto hand = session::seen_poses(taken.streams.marker_poses(device::MarkerId::camera_marker));
  if (!hand.empty()) tables.push_back({"hand.csv", session::pivot_csv(hand, false), hand.size()});
  next = fmt::format("palpate calibrate hand-eye --hand {} --eye {}/eye.csv --estimate-delay --rig FILE",
                     hand.empty() ? "FILE" : out + "/hand.csv", out);
  return write_samples(options.source, "board", taken, tables, counts, next);
}

}  // namespace

void add_sample_board(CLI::App& sample) {
  auto options = std::make_shared<BoardSampling>();
  auto* command = sample.add_subcommand("board",
                                        "Where the camera was at a calibration board: eye.csv, corners.csv, "
                                        "stamps.csv; with a tracker hand.csv beside");
  add_sample_options(*command, options->source, {.camera = true});
  add_board_options(*command, options->board);
  command->remove_option(command->get_option("--corners"));
  command->remove_option(command->get_option("--size-px"));
  command
      ->add_option("--stamps", options->stamps, "When each of the images was taken, a CSV table image,time_s")
      ->type_name("FILE");
  command
      ->add_option("--lens", options->lens,
                   "The lens, a rig file or a result of calibrate camera; default: the rig's. Without one "
                   "corners alone")
      ->type_name("FILE");
  on(command, [options] { return sample_board_tables(*options); });
}

}  // namespace palpate::tools::commands
