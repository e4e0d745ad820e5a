#include <algorithm>
#include <memory>

#include "palpate/calibration/surface.h"
#include "palpate/core/units.h"
#include "palpate/device/point_file.h"
#include "palpate/device/repeats.h"
#include "tools/commands/command.h"
#include "tools/commands/result_output.h"
#include "tools/commands/table_source.h"

namespace palpate::tools::commands {
namespace {

constexpr double kSmallSurface = 0.02;                    // m
constexpr double kPoorTouch = 0.002, kPoorShare = 0.002;  // m; of the diagonal

struct SurfaceArguments {
  ResultOptions result;
  std::string points, name;
};

struct NamedPoints : calibration::SurfaceTouches {
  std::size_t repeats = 0;  // touches left out
};

device::Reading reading_of_touch(const calibration::TouchedPoint& point) {
  return device::Reading().add(point.place.m).add(point.corner);
}

// "table_3" -> table, 3; "3" -> "", 3; anything else -> itself, 0.
std::pair<std::string, int> split_label(const std::string& label) {
  if (label.empty() || label.back() < '1' || label.back() > '4') return {label, 0};
  if (label.size() == 1) return {"", label.back() - '0'};
  const char before = label[label.size() - 2];
  if (before != '_' && before != ' ' && before != '-') return {label, 0};
  return {label.substr(0, label.size() - 2), label.back() - '0'};
}

// One surface, or as many as a `surface` column names, or labels such as table_1 ... wall_4. A `corner`
// column holds 1 to 4, or 0 for points elsewhere on the surface.
Expected<std::vector<NamedPoints>> group(const device::PointFile& file, const std::string& fallback) {
  std::vector<NamedPoints> surfaces;
  const auto surface = file.table.find("surface"), corner = file.table.find("corner"),
             label = file.table.find("label");
  for (std::size_t i = 0; i < file.points.size(); ++i) {
    const auto [stem, number] =
        label ? split_label(file.table.text[i][*label]) : std::pair<std::string, int>{"", 0};
    std::string name = surface ? file.table.text[i][*surface] : stem;
    if (name.empty()) name = fallback;
    auto at = std::find_if(surfaces.begin(), surfaces.end(), [&](const auto& s) { return s.name == name; });
    if (at == surfaces.end()) at = surfaces.insert(at, {{name, {}}, 0});
    calibration::TouchedPoint point{{file.points[i]}, number};
    if (corner) {
      const double given = file.table.text[i][*corner].empty() ? 0.0 : file.table.rows[i][*corner];
      if (!(given >= 0.0 && given <= 4.0) || given != std::floor(given))
        return wrong_use(
            "{}:{}: corner is '{}'; 1 to 4, or 0 for a point elsewhere on the surface, is expected",
            file.source, file.table.line[i], file.table.text[i][*corner]);
      point.corner = static_cast<int>(given);
    }
    at->points.push_back(point);
  }
  // labels that name single points, not surfaces: one surface, touched in order
  if (!surface &&
      std::any_of(surfaces.begin(), surfaces.end(), [](const auto& s) { return s.points.size() < 4; })) {
    surfaces.assign(1, {{fallback, {}}, 0});
    for (const auto& point : file.points) surfaces[0].points.push_back({{point}, 0});
  }
  for (auto& one : surfaces) one.repeats = device::drop_repeats(one.points, reading_of_touch);
  return surfaces;
}

std::vector<std::string> warnings_of(const NamedPoints& touched,
                                     const Estimate<calibration::RectangleFit>& estimate) {
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
  if (touched.repeats > 0) warnings.push_back(device::repeats_warning(touched.repeats));
  const auto& points = touched.points;
  if (points.size() > 4 &&
      std::all_of(points.begin(), points.end(), [](const auto& p) { return p.corner == 0; }))
    warnings.push_back(
        fmt::format("{}: no point says which corner it is; the first four are taken as the corners in order, "
                    "the other {} as lying anywhere on the surface (a corner column, 1 to 4, tells)",
                    touched.name, points.size() - 4));
  return warnings;
}

Json to_json(const std::string& name, const Estimate<calibration::RectangleFit>& estimate,
             const std::vector<std::string>& warnings) {
  const calibration::RectangleFit& fit = estimate.value;
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

Expected<void> run_surface(const SurfaceArguments& options) {
  const auto rig_before = start_rig(options.result);
  if (!rig_before) return tl::unexpected(rig_before.error());
  const auto file = device::read_points(options.points);
  if (!file) return tl::unexpected(file.error());
  auto surfaces = group(*file, options.name.empty() ? "surface" : options.name);
  if (!surfaces) return tl::unexpected(surfaces.error());
  if (!options.name.empty())
    std::erase_if(*surfaces, [&](const auto& surface) { return surface.name != options.name; });
  if (surfaces->empty())
    return wrong_use("{}: has no points of the surface '{}'", file->source, options.name);
  // What the rig's other surfaces tell of the hand; these ones' old touches are replaced.
  auto others = rig_before->surfaces;
  std::erase_if(others, [&](const auto& known) {
    return std::any_of(surfaces->begin(), surfaces->end(),
                       [&](const auto& surface) { return surface.name == known.name; });
  });
  const auto fits = calibration::fit_rectangles({surfaces->begin(), surfaces->end()},
                                                {.touch = calibration::noise::touch_noise_of(others)});
  if (!fits) return refused("{}: {}", file->source, fits.error().message);
  Result result;
  Json all = Json::array();
  std::vector<rig::SurfaceCalibration> found;
  for (std::size_t i = 0; i < fits->size(); ++i) {
    const NamedPoints& surface = (*surfaces)[i];
    const auto& estimate = (*fits)[i];
    const auto warnings = warnings_of(surface, estimate);
    all.push_back(to_json(surface.name, estimate, warnings));
    const calibration::RectangleFit& fit = estimate.value;
    found.push_back({surface.name,
                     fit.X_world_rectangle,
                     fit.width,
                     fit.height,
                     estimate.covariance,
                     {rig::utc_now(), file->hash, "rectangle", kMm * rms_per_component(estimate.residuals)},
                     fit.seen});
    result.summary.push_back(fmt::format("{}: {:.1f} x {:.1f} mm, {:.3f} mm rms per component over {} points",
                                         surface.name, kMm * fit.width, kMm * fit.height,
                                         all.back()["rms_mm"].get<double>(), surface.points.size()));
    for (const auto& warning : warnings) result.summary.push_back("warning: " + warning);
  }
  if (all.size() == 1) {
    result.json = all[0];
  } else {
    result.json["surfaces"] = all;
  }
  result.json["data"] = Json{{"file", file->source}, {"hash", file->hash}};
  result.store = [&](rig::Rig& rig) {
    for (const auto& surface : found) {
      const auto at = std::find_if(rig.surfaces.begin(), rig.surfaces.end(),
                                   [&](const auto& known) { return known.name == surface.name; });
      if (at == rig.surfaces.end())
        rig.surfaces.push_back(surface);
      else
        *at = surface;
    }
  };
  return write_result(options.result, result);
}

}  // namespace

void add_calibrate_surface(CLI::App& calibrate) {
  auto options = std::make_shared<SurfaceArguments>();
  auto* command =
      calibrate.add_subcommand("surface", "A rectangle from touched points: its corners in order around it");
  command
      ->add_option("--points", options->points,
                   "Touched points, CSV; a corner column (1-4) allows more than four")
      ->type_name("FILE");
  command->add_option("--name", options->name, "Name of the surface; with a surface column, which one")
      ->type_name("NAME");
  add_result_options(*command, options->result);
  const auto tables = std::make_shared<TableSource>();
  tables->add("--points", options->points, "surface");
  tables->add_options(*command);
  on(command, tables, [options] { return run_surface(*options); });
}

}  // namespace palpate::tools::commands
