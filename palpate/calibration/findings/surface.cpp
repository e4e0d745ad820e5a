#include "palpate/calibration/findings/surface.h"

#include <algorithm>

#include "palpate/device/repeats.h"

namespace palpate::calibration::findings {
namespace {

constexpr double kSmallSurface = 0.02;                    // m
constexpr double kBehind = 0.05;                          // m, of the tracker: clearly so
constexpr double kLevel = 0.5;                            // of a normal along the world's up, y
constexpr double kPoorTouch = 0.002, kPoorShare = 0.002;  // m; of the diagonal

device::Reading reading_of_touch(const TouchedPoint& point) {
  return device::Reading().add(point.place.m).add(point.corner);
}

std::vector<std::string> warnings_of(const SurfaceTouches& touched, const Estimate<RectangleFit>& estimate,
                                     std::size_t repeats) {
  std::vector<std::string> warnings;
  const double diagonal = std::hypot(estimate.value.width, estimate.value.height);
  if (diagonal < kSmallSurface)
    warnings.push_back(fmt::format("{}: is only {:.1f} mm across; check the unit in the header (_mm or _m)",
                                   touched.name, kMm * diagonal));
  // One wrong corner is shared out among all four: no residual of theirs is much larger than another.
  double worst = 0.0;
  for (const auto& r : estimate.residuals) worst = std::max(worst, r.norm());
  if (worst > std::max(kPoorTouch, kPoorShare * diagonal))
    warnings.push_back(fmt::format(
        "{}: the touches miss the best rectangle by up to {:.1f} mm, where a hand misses by some tenths: "
        "one of the corners was touched wrongly, or it is no rectangle; touch it again",
        touched.name, kMm * worst));
  // The tracker stands in the world's origin, above a table. Of a wall it may see either side.
  const auto& at = estimate.value.X_world_rectangle;
  const Vector3 normal = at.matrix().col(2);
  if (std::abs(normal.y()) > kLevel && normal.dot(at.translation) > kBehind)
    warnings.push_back(
        fmt::format("{}: the tracker would be behind the surface: were the corners touched clockwise? As "
                    "seen from the front they go "
                    "counter-clockwise",
                    touched.name));
  if (repeats > 0) warnings.push_back(device::repeats_warning(repeats));
  const auto& points = touched.points;
  if (points.size() > 4 &&
      std::all_of(points.begin(), points.end(), [](const auto& p) { return p.corner == 0; }))
    warnings.push_back(
        fmt::format("{}: no point says which corner it is; the first four are taken as the corners in order, "
                    "the other {} as lying anywhere on the surface (a corner column, 1 to 4, tells)",
                    touched.name, points.size() - 4));
  return warnings;
}

Json to_json(const std::string& name, const Estimate<RectangleFit>& estimate,
             const std::vector<std::string>& warnings) {
  const RectangleFit& fit = estimate.value;
  const auto std_all = standard_deviations(estimate.covariance);
  Json json;
  json["name"] = name;
  json["corners_mm"] = Json::array();
  for (int c = 1; c <= 4; ++c) json["corners_mm"].push_back(json_list(fit.corner(c).m, kMm));
  json["width_mm"] = kMm * fit.width;
  json["height_mm"] = kMm * fit.height;
  json["normal"] = json_list(Vector3(fit.X_world_rectangle.matrix().col(2)));
  json["translation_mm"] = json_list(fit.X_world_rectangle.translation, kMm);
  json["rotation_qwxyz"] = json_quaternion(fit.X_world_rectangle.rotation);
  json["rms_mm"] = kMm * rms_per_component(estimate.residuals);
  json["residuals_mm"] = Json::array();
  for (const auto& r : estimate.residuals) json["residuals_mm"].push_back(json_list(r, kMm));
  json["points"] = estimate.residuals.size();
  json["touch_sd_mm"] = kMm * fit.touch.sd;
  json["touch_freedoms"] = fit.touch.freedoms;
  json["warnings"] = warnings;
  Eigen::VectorXd scales(8);
  scales << Vector3::Constant(kDegreesPerRadian), Eigen::VectorXd::Constant(5, kMm);
  json["std"] = Json{{"rotation_deg", json_list(std_all.head<3>(), kDegreesPerRadian)},
                     {"translation_mm", json_list(std_all.segment<3>(3), kMm)},
                     {"width_mm", kMm * std_all[6]},
                     {"height_mm", kMm * std_all[7]}};
  json["covariance"] =
      json_covariance({"rotation_x_deg", "rotation_y_deg", "rotation_z_deg", "translation_x_mm",
                       "translation_y_mm", "translation_z_mm", "width_mm", "height_mm"},
                      estimate.covariance, scales);
  return json;
}

}  // namespace

Expected<SurfaceFindings> find_surfaces(std::vector<SurfaceTouches> touched,
                                        const RectangleOptions& options) {
  std::vector<std::size_t> repeats;
  for (auto& surface : touched) repeats.push_back(device::drop_repeats(surface.points, reading_of_touch));
  auto estimates = fit_rectangles(touched, options);
  if (!estimates) return tl::unexpected(estimates.error());
  SurfaceFindings found{std::move(*estimates), {}, {}};
  for (std::size_t i = 0; i < touched.size(); ++i)
    found.json.push_back(to_json(touched[i].name, found.estimates[i],
                                 warnings_of(touched[i], found.estimates[i], repeats[i])));
  if (found.json.size() == 1)
    found.all = found.json[0];
  else
    found.all["surfaces"] = found.json;
  return found;
}

}  // namespace palpate::calibration::findings
