#include <memory>

#include "palpate/core/units.h"
#include "palpate/device/repeats.h"
#include "palpate/vision/camera.h"
#include "palpate/vision/charuco.h"
#include "tools/commands/command.h"
#include "tools/commands/result_output.h"

namespace palpate::tools::commands {
namespace {

struct CameraArguments {
  ResultOptions result;
  std::string camera = "left";  // of two: the one whose result the rig gets
  std::string images, corners, board = "9x6", size;
  double square_mm = 25.0;
  int corner_window_px = 11;  // as OpenCV's own calibration program has it
  bool reject_outliers = false;
};

const std::vector<std::string> kLensNames = {"fx_px", "fy_px", "cx_px", "cy_px", "k1",
                                             "k2",    "p1",    "p2",    "k3"};

bool is_charuco(const CameraArguments& options) { return options.board.ends_with(".toml"); }

Expected<vision::BoardViews> read_views(const CameraArguments& options) {
  if (options.images.empty() == options.corners.empty())
    return wrong_use("calibrate camera: exactly one of --images and --corners is expected");
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

Expected<void> set_size(const CameraArguments& options, vision::BoardViews& views,
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
        return wrong_use("view '{}': corner at ({:.1f}, {:.1f}) is outside the image of {}x{} px", view.name,
                         u.x(), u.y(), views.width, views.height);
  return {};
}

Json to_json(const vision::BoardViews& views, const Estimate<vision::CameraSolution>& fit,
             const std::vector<std::string>& warnings) {
  const auto& s = fit.value;
  const auto std_all = standard_deviations(fit.covariance);
  Json json;
  json["rms_px"] = s.rms_px;
  json["fx"] = s.model.fx, json["fy"] = s.model.fy, json["cx"] = s.model.cx, json["cy"] = s.model.cy;
  json["distortion"] = s.model.distortion;
  json["width_px"] = s.model.width, json["height_px"] = s.model.height;
  json["outlier_views"] = s.outlier_views();
  json["views"] = Json::array();
  for (const auto& view : s.views)
    json["views"].push_back(
        {{"name", view.name}, {"rms_px", view.rms_px}, {"outlier", view.outlier}, {"used", view.used}});
  json["board_not_found"] = views.not_found;
  json["condition"] = fit.condition;
  json["std"] = {{"fx", std_all[0]},
                 {"fy", std_all[1]},
                 {"cx", std_all[2]},
                 {"cy", std_all[3]},
                 {"distortion", json_list(std_all.tail<5>())}};
  json["covariance"] = json_covariance(kLensNames, fit.covariance, Eigen::VectorXd::Ones(9));
  json["warnings"] = warnings;
  json["data"] = {{"hash", views.data_hash}};
  return json;
}

Expected<void> run_camera(const CameraArguments& options) {
  if (const auto rig = start_rig(options.result); !rig) return tl::unexpected(rig.error());
  auto views = read_views(options);
  if (!views) return tl::unexpected(views.error());
  std::vector<std::string> warnings;
  for (const auto& name : views->not_found)
    warnings.push_back(is_charuco(options)
                           ? fmt::format("fewer than 6 corners of the board in '{}'", name)
                           : fmt::format("no complete {} board in '{}'", options.board, name));
  const std::string source = options.images.empty() ? options.corners : options.images;
  if (views->views.empty() && is_charuco(options))
    return refused("{}: the board of {} is in none of the pictures; is it the one that was printed?", source,
                   options.board);
  if (views->views.empty())
    return refused("{}: no complete board of {} inner corners was found; check --board", source,
                   options.board);
  if (const auto done = set_size(options, *views, warnings); !done) return done;
  const auto repeats = device::drop_repeats(views->views, [](const vision::BoardView& view) {
    device::Reading reading;
    for (const auto& corner : view.image) reading.add(corner);
    return reading;
  });
  if (repeats > 0)
    warnings.push_back(counted(repeats, "view") + (repeats == 1 ? " shows" : " show") +
                       " the corners of an earlier one to the last digit (the same photograph twice?); each "
                       "counts once");
  const auto fit = vision::calibrate_camera(views->views, views->width, views->height,
                                            {.reject_outlier_views = options.reject_outliers});
  if (!fit) return refused("{}: {}", source, fit.error().message);
  warnings.insert(warnings.end(), fit->value.warnings.begin(), fit->value.warnings.end());

  const auto& s = fit->value;
  const auto sd = standard_deviations(fit->covariance);
  Result result{to_json(*views, *fit, warnings), {}, {}};
  result.summary.push_back(fmt::format("focal length   {:.3f} +- {:.3f}, {:.3f} +- {:.3f} px", s.model.fx,
                                       sd[0], s.model.fy, sd[1]));
  result.summary.push_back(fmt::format("centre         {:.3f} +- {:.3f}, {:.3f} +- {:.3f} px", s.model.cx,
                                       sd[2], s.model.cy, sd[3]));
  result.summary.push_back(
      fmt::format("distortion     {} (k1 k2 p1 p2 k3)",
                  shown(Eigen::Map<const Eigen::VectorXd>(s.model.distortion.data(), 5))));
  result.summary.push_back(
      fmt::format("residual       {:.4f} px rms over {} views", s.rms_px, s.views.size()));
  for (const auto& warning : warnings) result.summary.push_back("warning: " + warning);
  result.store = [&](rig::Rig& rig) {
    auto& camera = options.camera == "right" ? rig.right_camera : rig.camera;
    // Photographs in files hold sRGB; corners found elsewhere say nothing of it.
    const device::Encoding encoding = !options.images.empty() ? device::Encoding::srgb
                                      : camera                ? camera->encoding
                                                              : device::Encoding::root;
    camera = rig::CameraCalibration{
        s.model,
        fit->covariance,
        {rig::utc_now(), views->data_hash, is_charuco(options) ? "charuco" : "chessboard", s.rms_px},
        encoding};
  };
  return write_result(options.result, result);
}

}  // namespace

void add_calibrate_camera(CLI::App& calibrate) {
  auto options = std::make_shared<CameraArguments>();
  auto* command = calibrate.add_subcommand("camera", "A camera's lens, from views of a chessboard");
  command
      ->add_option("--images", options->images,
                   "Photographs of the board, a quoted pattern such as 'left*.jpg'")
      ->type_name("GLOB");
  command->add_option("--corners", options->corners, "Corners found elsewhere, a CSV table")
      ->type_name("FILE");
  command
      ->add_option(
          "--board", options->board,
          "Of a chessboard its inner corners, columns x rows; of a ChArUco board the file that `palpate "
          "board` wrote")
      ->type_name("9x6|FILE.toml")
      ->capture_default_str();
  command->add_option("--square-mm", options->square_mm, "Side of a square")->capture_default_str();
  command->add_option("--size-px", options->size, "Size of the images, where --corners does not tell it")
      ->type_name("640x480");
  command
      ->add_option("--corner-window-px", options->corner_window_px,
                   "Half the window in which a corner is refined; 0 = fitted to each view, better where "
                   "squares are small")
      ->check(CLI::Range(0, 50))
      ->capture_default_str();
  command->add_flag("--reject-outlier-views", options->reject_outliers,
                    "Fit again without the views that are flagged");
  add_camera_option(*command, options->camera);
  add_result_options(*command, options->result);
  on(command, [options] { return run_camera(*options); });
}

}  // namespace palpate::tools::commands
