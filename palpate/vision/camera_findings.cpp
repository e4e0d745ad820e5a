#include "palpate/vision/camera_findings.h"

#include <algorithm>
#include <limits>
#include <sstream>

#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/repeats.h"
#include "palpate/math/json_values.h"

namespace palpate::vision {
namespace {

std::vector<std::string> lens_names(device::LensKind kind) {
  std::vector<std::string> names{"fx_px", "fy_px", "cx_px", "cy_px"};
  std::istringstream words(device::coefficient_names(kind));
  for (std::string word; words >> word;) names.push_back(word);
  return names;
}

Json lens_json(const BoardViews& views, const Estimate<CameraSolution>& fit,
               const std::vector<std::string>& warnings) {
  const auto& s = fit.value;
  const auto std_all = standard_deviations(fit.covariance);
  Json json;
  json["rms_px"] = s.rms_px;
  json["fx"] = s.model.fx, json["fy"] = s.model.fy, json["cx"] = s.model.cx, json["cy"] = s.model.cy;
  // The same under the rig file's names.
  json["fx_px"] = s.model.fx, json["fy_px"] = s.model.fy, json["cx_px"] = s.model.cx,
  json["cy_px"] = s.model.cy;
  json["lens"] = device::lens_word(s.model.kind);
  const auto coefficients = s.model.coefficients();
  json["distortion"] = std::vector<double>(coefficients.begin(), coefficients.end());
  json["width_px"] = s.model.width, json["height_px"] = s.model.height;
  const auto [nearest, farthest] = board_distances(s);
  json["board_distance_mm"] = {kMillimetresPerMetre * nearest, kMillimetresPerMetre * farthest};
  json["outlier_views"] = s.outlier_views();
  json["views"] = Json::array();
  for (const auto& view : s.views)
    json["views"].push_back(
        {{"name", view.name}, {"rms_px", view.rms_px}, {"outlier", view.outlier}, {"used", view.used}});
  json["board_not_found"] = views.not_found;
  json["condition"] = fit.condition;
  json["std"] = {
      {"fx", std_all[0]},
      {"fy", std_all[1]},
      {"cx", std_all[2]},
      {"cy", std_all[3]},
      {"distortion", json_list(std_all.segment(4, static_cast<Eigen::Index>(coefficients.size())))}};
  const auto names = lens_names(s.model.kind);
  const auto n = static_cast<Eigen::Index>(names.size());
  json["covariance"] = json_covariance(names, fit.covariance.topLeftCorner(n, n), Eigen::VectorXd::Ones(n));
  json["warnings"] = warnings;
  return json;
}

}  // namespace

std::pair<double, double> board_distances(const CameraSolution& lens) {
  std::pair<double, double> range{std::numeric_limits<double>::infinity(), 0.0};
  for (const auto& view : lens.views) {
    const double distance = view.X_camera_board.translation.norm();
    range = {std::min(range.first, distance), std::max(range.second, distance)};
  }
  return range;
}

Expected<CameraFindings> find_camera(BoardViews views, const CameraOptions& options,
                                     std::vector<std::string> warnings) {
  const auto repeats = device::drop_repeats(views.views, [](const BoardView& view) {
    device::Reading reading;
    for (const auto& corner : view.image) reading.add(corner);
    return reading;
  });
  if (repeats > 0)
    warnings.push_back(counted(repeats, "view") + (repeats == 1 ? " shows" : " show") +
                       " the corners of an earlier one to the last digit (the same photograph twice?); each "
                       "counts once");
  auto fit = calibrate_camera(views.views, views.width, views.height, options);
  if (!fit) return tl::unexpected(fit.error());
  warnings.insert(warnings.end(), fit->value.warnings.begin(), fit->value.warnings.end());
  Json json = lens_json(views, *fit, warnings);
  return CameraFindings{std::move(*fit), std::move(warnings), std::move(json)};
}

}  // namespace palpate::vision
