#include <algorithm>
#include <memory>

#include "palpate/calibration/findings/surface.h"
#include "palpate/core/text.h"
#include "palpate/device/point_file.h"
#include "tools/commands/command.h"
#include "tools/commands/files_of_others.h"
#include "tools/commands/result_output.h"
#include "tools/commands/table_source.h"

namespace palpate::tools::commands {
namespace {

namespace findings = calibration::findings;

const std::string kUnnamed = "surface";

struct SurfaceArguments {
  ResultOptions result;
  std::string points, name;
};

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
Expected<std::vector<calibration::SurfaceTouches>> group(const device::PointFile& file,
                                                         const std::string& fallback) {
  std::vector<calibration::SurfaceTouches> surfaces;
  const auto surface = file.table.find("surface"), corner = file.table.find("corner"),
             label = file.table.find("label");
  for (std::size_t i = 0; i < file.points.size(); ++i) {
    const auto [stem, number] =
        label ? split_label(file.table.text[i][*label]) : std::pair<std::string, int>{"", 0};
    std::string name = surface ? file.table.text[i][*surface] : stem;
    if (name.empty()) name = fallback;
    auto at = std::find_if(surfaces.begin(), surfaces.end(), [&](const auto& s) { return s.name == name; });
    if (at == surfaces.end()) at = surfaces.insert(at, calibration::SurfaceTouches{name, {}});
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
    surfaces.assign(1, calibration::SurfaceTouches{fallback, {}});
    for (const auto& point : file.points) surfaces[0].points.push_back({{point}, 0});
  }
  return surfaces;
}

Expected<void> run_surface(const SurfaceArguments& options) {
  const auto rig_before = start_rig(options.result);
  if (!rig_before) return tl::unexpected(rig_before.error());
  const auto file = read_points(options.points);
  if (!file) return tl::unexpected(file.error());
  auto surfaces = group(*file, options.name.empty() ? kUnnamed : options.name);
  if (!surfaces) return tl::unexpected(surfaces.error());
  if (!options.name.empty()) {
    std::string names;
    for (const auto& surface : *surfaces) names += (names.empty() ? "" : ", ") + excerpt(surface.name, 60);
    std::erase_if(*surfaces, [&](const auto& surface) { return surface.name != options.name; });
    if (surfaces->empty())
      return wrong_use("{}: has no points of the surface '{}'; there are {}", file->source,
                       excerpt(options.name), excerpt(names, 300));
  }
  // What the rig's other surfaces tell of the hand; these ones' old touches are replaced.
  auto others = rig_before->surfaces;
  std::erase_if(others, [&](const auto& known) {
    return std::any_of(surfaces->begin(), surfaces->end(),
                       [&](const auto& surface) { return surface.name == known.name; });
  });
  const auto fits = findings::find_surfaces(*surfaces, {.touch = calibration::noise::touch_noise_of(others)});
  if (!fits) return refused("{}: {}", file->source, fits.error().message);
  Result result{fits->all, {}, {}};
  std::vector<rig::SurfaceCalibration> found;
  for (std::size_t i = 0; i < surfaces->size(); ++i) {
    const std::string& name = (*surfaces)[i].name;
    const auto& estimate = fits->estimates[i];
    const Json& json = fits->json[i];
    const calibration::RectangleFit& fit = estimate.value;
    const double rms_mm = json["rms_mm"].get<double>();
    found.push_back({name,
                     fit.X_world_rectangle,
                     fit.width,
                     fit.height,
                     estimate.covariance,
                     {rig::utc_now(), file->hash, "rectangle", rms_mm},
                     fit.seen});
    result.summary.push_back(fmt::format("{}: {:.1f} x {:.1f} mm, {:.3f} mm rms per component over {} points",
                                         name, kMm * fit.width, kMm * fit.height, rms_mm,
                                         json["points"].get<std::size_t>()));
    if (options.name.empty() && name == kUnnamed)
      result.summary.push_back(
          fmt::format("the surface is called '{}'; --name NAME calls it otherwise, as 'table'", name));
    for (const auto& warning : json["warnings"])
      result.summary.push_back("warning: " + warning.get<std::string>());
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
