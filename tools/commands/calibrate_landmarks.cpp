#include <cmath>
#include <memory>
#include <optional>

#include "palpate/calibration/findings/landmarks.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/point_file.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/files_of_others.h"
#include "tools/commands/result_output.h"
#include "tools/commands/table_source.h"

namespace palpate::tools::commands {
namespace {

namespace findings = calibration::findings;

struct LandmarksArguments {
  ResultOptions result;
  std::string points;
  std::optional<double> touch_mm;
  double tracker_mm = 0.1;
  double diameter_mm = mm_from_metres(calibration::LandmarkTouchOptions{}.diameter);
};

Expected<void> run_landmarks(const LandmarksArguments& options) {
  const auto rig = start_rig(options.result);
  if (!rig) return tl::unexpected(rig.error());
  if (options.result.rig.empty())
    return wrong_use("--rig is required: its surfaces say how the landmarks are turned");
  const auto file = read_points(options.points);
  if (!file) return tl::unexpected(file.error());
  std::vector<calibration::LandmarkTouch> touches;
  const double tracker = metres_from_mm(options.tracker_mm);
  for (std::size_t i = 0; i < file->points.size(); ++i)
    touches.push_back({file->labels.empty() ? std::to_string(i + 1) : file->labels[i], file->points[i],
                       tracker * tracker * Matrix3::Identity()});
  rig::TouchNoise hand = calibration::noise::touch_noise_of(rig->surfaces);
  if (options.touch_mm) hand = {metres_from_mm(*options.touch_mm), findings::kStatedFreedoms};
  const auto fit = findings::find_landmarks(std::move(touches), rig->surfaces,
                                            {.touch = hand, .diameter = metres_from_mm(options.diameter_mm)});
  if (!fit) return refused("{}: {}", file->source, fit.error().message);
  Result result{fit->json, {}, {}};
  result.json["data"] = Json{{"file", file->source}, {"hash", file->hash}};
  const auto& found = fit->estimate.value;
  for (std::size_t k = 0; k < found.landmarks.size(); ++k) {
    const double off = std::abs(found.distance[k]);
    result.summary.push_back(fmt::format(
        "{:<12} {} mm  +- {}, {} '{}'", excerpt(found.labels[k]), shown(found.landmarks[k].place.m, kMm),
        shown(standard_deviations(found.landmarks[k].covariance), kMm),
        off > findings::kOffSurface ? fmt::format("{:.1f} mm off", mm_from_metres(off)) : "on",
        found.surface[k]));
  }
  for (const auto& warning : result.json["warnings"])
    result.summary.push_back("warning: " + warning.get<std::string>());
  if (!rig->landmarks.empty() && rig->landmarks.size() != found.landmarks.size())
    result.summary.push_back(fmt::format("the rig had {}; these {} take their place",
                                         counted(rig->landmarks.size(), "landmark"), found.landmarks.size()));
  result.store = [&](rig::Rig& target) {
    target.landmarks = found.landmarks;
    // Of lens, hand-eye and the landmarks that were there before, together.
    target.registration_covariance.resize(0, 0);
    target.right_registration_covariance.resize(0, 0);
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
