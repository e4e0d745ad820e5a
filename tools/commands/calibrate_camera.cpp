#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "palpate/core/units.h"
#include "palpate/device/repeats.h"
#include "palpate/vision/camera.h"
#include "tools/commands/board_options.h"
#include "tools/commands/command.h"
#include "tools/commands/result_output.h"
#include "tools/commands/table_source.h"

namespace palpate::tools::commands {
namespace {

struct CameraArguments {
  ResultOptions result;
  std::string camera = "left";  // of two: the one whose result the rig gets
  BoardOptions board;
  bool reject_outliers = false;
};

const std::vector<std::string> kLensNames = {"fx_px", "fy_px", "cx_px", "cy_px", "k1",
                                             "k2",    "p1",    "p2",    "k3"};

// How far the board's first corner was from the camera, nearest and farthest view: what another unit of the squares
// changes, and nothing else does.
std::pair<double, double> board_distances(const vision::CameraSolution& lens) {
  std::pair<double, double> range{std::numeric_limits<double>::infinity(), 0.0};
  for (const auto& view : lens.views) {
    const double distance = view.X_camera_board.translation.norm();
    range = {std::min(range.first, distance), std::max(range.second, distance)};
  }
  return range;
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
  const auto distances = board_distances(s);
  json["board_distance_mm"] = {kMm * distances.first, kMm * distances.second};
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
  std::vector<std::string> warnings;
  auto views = read_board_views(options.board, "calibrate camera", warnings);
  if (!views) return tl::unexpected(views.error());
  if (const auto done = set_size(options.board, *views, warnings); !done) return done;
  const std::string source = source_of(options.board);
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
  const auto [nearest, farthest] = board_distances(s);
  result.summary.push_back(fmt::format("board          {:.3f} to {:.3f} m away", nearest, farthest));
  for (const auto& warning : warnings) result.summary.push_back("warning: " + warning);
  result.store = [&](rig::Rig& rig) {
    auto& camera = options.camera == "right" ? rig.right_camera : rig.camera;
    // Photographs in files hold sRGB; corners found elsewhere say nothing of it.
    const device::Encoding encoding = !options.board.images.empty() ? device::Encoding::srgb
                                      : camera                      ? camera->encoding
                                                                    : device::Encoding::root;
    camera = rig::CameraCalibration{
        s.model,
        fit->covariance,
        {rig::utc_now(), views->data_hash, is_charuco(options.board) ? "charuco" : "chessboard", s.rms_px},
        encoding};
  };
  return write_result(options.result, result);
}

}  // namespace

void add_calibrate_camera(CLI::App& calibrate) {
  auto options = std::make_shared<CameraArguments>();
  auto* command = calibrate.add_subcommand("camera", "A camera's lens, from views of a chessboard");
  add_board_options(*command, options->board);
  command->add_flag("--reject-outlier-views", options->reject_outliers,
                    "Fit again without the views that are flagged");
  add_camera_option(*command, options->camera);
  add_result_options(*command, options->result);
  const auto tables = std::make_shared<TableSource>();
  tables->add(
      "--corners", options->board.corners,
      [options] { return options->board.images.empty() ? std::string("corners") : std::string(); }, false);
  tables->add_options(*command);
  on(command, tables, [options] { return run_camera(*options); });
}

}  // namespace palpate::tools::commands
