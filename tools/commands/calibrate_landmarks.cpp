#include <algorithm>
#include <memory>
#include <optional>
#include <set>

#include "palpate/calibration/touched_landmarks.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/point_file.h"
#include "palpate/device/repeats.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/result_output.h"
#include "tools/commands/table_source.h"

namespace palpate::tools::commands {
namespace {

constexpr double kStatedFreedoms = 1e6;  // who states it knows it
constexpr double kOffSurface = 0.010;    // m; a dot further from every surface lies on none of them

struct LandmarksArguments {
  ResultOptions result;
  std::string points;
  std::optional<double> touch_mm;
  double tracker_mm = 0.1;
  double diameter_mm = mm_from_metres(calibration::LandmarkTouchOptions{}.diameter);
};

Json landmarks_json(const Estimate<calibration::TouchedLandmarks>& estimate, const device::PointFile& file) {
  const calibration::TouchedLandmarks& found = estimate.value;
  const auto sd = standard_deviations(estimate.covariance);
  Json json;
  json["landmarks"] = Json::array();
  json["warnings"] = Json::array();
  Json all = Json::array();
  std::vector<std::string> names;
  for (std::size_t k = 0; k < found.landmarks.size(); ++k) {
    const auto& landmark = found.landmarks[k];
    const Vector3 std_k = sd.segment<3>(3 * static_cast<Eigen::Index>(k));
    all.push_back(json_list(std_k, kMm));
    json["landmarks"].push_back({{"label", found.labels[k]},
                                 {"place_mm", json_list(landmark.place.m, kMm)},
                                 {"std_mm", json_list(std_k, kMm)},
                                 {"normal", json_list(landmark.normal)},
                                 {"surface", found.surface[k]},
                                 {"off_surface_mm", kMm * found.distance[k]},
                                 {"touches", found.touches[k]}});
    for (const char* axis : {"x", "y", "z"}) names.push_back(fmt::format("{}_{}_mm", found.labels[k], axis));
    if (found.distance[k] > kOffSurface)
      json["warnings"].push_back(
          fmt::format("landmark '{}' lies {:.1f} mm off the nearest surface ({}): its normal is only a guess",
                      excerpt(found.labels[k]), kMm * found.distance[k], found.surface[k]));
  }
  json["touch_sd_mm"] = kMm * found.touch.sd;
  json["touch_freedoms"] = found.touch.freedoms;
  json["rms_mm"] = kMm * rms_per_component(estimate.residuals);
  json["std"] = {{"place_mm", all}};
  json["covariance"] = json_covariance(names, estimate.covariance, Eigen::VectorXd::Constant(sd.size(), kMm));
  json["data"] = Json{{"file", file.source}, {"hash", file.hash}};
  return json;
}

Expected<void> run_landmarks(const LandmarksArguments& options) {
  const auto rig = start_rig(options.result);
  if (!rig) return tl::unexpected(rig.error());
  if (options.result.rig.empty())
    return wrong_use("--rig is required: its surfaces say how the landmarks are turned");
  const auto file = device::read_points(options.points);
  if (!file) return tl::unexpected(file.error());
  std::vector<calibration::LandmarkTouch> touches;
  const double tracker = metres_from_mm(options.tracker_mm);
  std::set<std::pair<std::string, device::Reading>> known;
  std::size_t repeats = 0;
  for (std::size_t i = 0; i < file->points.size(); ++i) {
    const auto label = file->labels.empty() ? std::to_string(i + 1) : file->labels[i];
    if (known.insert({label, device::Reading().add(file->points[i])}).second)
      touches.push_back({label, file->points[i], tracker * tracker * Matrix3::Identity()});
    else
      ++repeats;
  }
  rig::TouchNoise hand = calibration::noise::touch_noise_of(rig->surfaces);
  if (options.touch_mm) hand = {metres_from_mm(*options.touch_mm), kStatedFreedoms};
  const auto estimate = calibration::landmarks_from_touches(
      touches, rig->surfaces, {.touch = hand, .diameter = metres_from_mm(options.diameter_mm)});
  if (!estimate) return refused("{}: {}", file->source, estimate.error().message);
  Result result{landmarks_json(*estimate, *file), {}, {}};
  if (repeats > 0) result.json["warnings"].push_back(device::repeats_warning(repeats));
  const auto& found = estimate->value;
  for (std::size_t k = 0; k < found.landmarks.size(); ++k)
    result.summary.push_back(fmt::format(
        "{:<12} {} mm  +- {}, on the {}", excerpt(found.labels[k]), shown(found.landmarks[k].place.m, kMm),
        shown(standard_deviations(found.landmarks[k].covariance), kMm), found.surface[k]));
  for (const auto& warning : result.json["warnings"])
    result.summary.push_back("warning: " + warning.get<std::string>());
  result.store = [&](rig::Rig& target) {
    target.landmarks = found.landmarks;
    target.landmarks_from = {rig::utc_now(), file->hash, "touched", result.json["rms_mm"].get<double>()};
  };
  return write_result(options.result, result);
}

}  // namespace

void add_calibrate_landmarks(CLI::App& calibrate) {
  auto options = std::make_shared<LandmarksArguments>();
  auto* command = calibrate.add_subcommand(
      "landmarks", "The dots on table and walls, from touches of the pointer; needs calibrated surfaces");
  command
      ->add_option("--points", options->points,
                   "Touches of the dots' middles, CSV; a label column allows several of each")
      ->type_name("FILE");
  command
      ->add_option(
          "--touch-sd-mm", options->touch_mm,
          "How far a hand misses per axis, what the tracker adds by chance included (default: as the rig's "
          "surfaces tell of it)")
      ->check(between(0.001, 10.0));
  command
      ->add_option("--tracker-sd-mm", options->tracker_mm,
                   "The tracker's error per axis that touches of one place share")
      ->check(between(0.0, 10.0))
      ->capture_default_str();
  command->add_option("--diameter-mm", options->diameter_mm, "Of the dots")
      ->check(between(0.1, 1000.0))
      ->capture_default_str();
  add_result_options(*command, options->result);
  const auto tables = std::make_shared<TableSource>();
  tables->add("--points", options->points, "landmarks");
  tables->add_options(*command);
  on(command, tables, [options] { return run_landmarks(*options); });
}

}  // namespace palpate::tools::commands
