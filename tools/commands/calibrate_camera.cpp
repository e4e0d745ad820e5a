#include <memory>

#include "palpate/vision/camera_findings.h"
#include "tools/commands/board_options.h"
#include "tools/commands/command.h"
#include "tools/commands/lens_file.h"
#include "tools/commands/result_output.h"
#include "tools/commands/table_source.h"

namespace palpate::tools::commands {
namespace {

struct CameraArguments {
  ResultOptions result;
  std::string camera = "left";  // of two: the one whose result the rig gets
  BoardOptions board;
  bool reject_outliers = false;
  std::string lens;
};

Expected<void> run_camera(const CameraArguments& options) {
  const auto rig_before = start_rig(options.result);
  if (!rig_before) return tl::unexpected(rig_before.error());
  std::vector<std::string> warnings;
  auto views = read_board_views(options.board, "calibrate camera", warnings);
  if (!views) return tl::unexpected(views.error());
  if (const auto done = set_size(options.board, *views, warnings); !done) return done;
  const std::string source = source_of(options.board);
  const std::string hash = views->data_hash;
  const auto found = vision::find_camera(std::move(*views),
                                         {.reject_outlier_views = options.reject_outliers,
                                          .lens = lens_model(options.lens, *rig_before, options.camera)},
                                         std::move(warnings));
  if (!found) return refused("{}: {}", source, found.error().message);
  const auto& fit = found->estimate;
  const auto& s = fit.value;
  const auto sd = standard_deviations(fit.covariance);
  Result result{found->json, {}, {}};
  result.json["data"] = {{"hash", hash}};
  result.summary.push_back(fmt::format("focal length   {:.3f} +- {:.3f}, {:.3f} +- {:.3f} px", s.model.fx,
                                       sd[0], s.model.fy, sd[1]));
  result.summary.push_back(fmt::format("centre         {:.3f} +- {:.3f}, {:.3f} +- {:.3f} px", s.model.cx,
                                       sd[2], s.model.cy, sd[3]));
  const auto coefficients = s.model.coefficients();
  const Eigen::Map<const Eigen::VectorXd> terms(coefficients.data(),
                                                static_cast<Eigen::Index>(coefficients.size()));
  result.summary.push_back(
      fmt::format("distortion     {} ({})", shown(terms), device::coefficient_names(s.model.kind)));
  result.summary.push_back(
      fmt::format("residual       {:.4f} px rms over {} views", s.rms_px, s.views.size()));
  const auto [nearest, farthest] = vision::board_distances(s);
  result.summary.push_back(fmt::format("board          {:.3f} to {:.3f} m away", nearest, farthest));
  for (const auto& warning : found->warnings) result.summary.push_back("warning: " + warning);
  result.store = [&](rig::Rig& rig) {
    auto& camera = options.camera == "right" ? rig.right_camera : rig.camera;
    // Photographs in files hold sRGB; corners found elsewhere say nothing of it.
    const device::Encoding encoding = !options.board.images.empty() ? device::Encoding::srgb
                                      : camera                      ? camera->encoding
                                                                    : device::Encoding::root;
    camera = rig::CameraCalibration{
        s.model,
        fit.covariance,
        {rig::utc_now(), hash, is_charuco(options.board) ? "charuco" : "chessboard", s.rms_px},
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
  add_lens_model_option(*command, options->lens);
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
