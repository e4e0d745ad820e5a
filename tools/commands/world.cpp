// palpate world: makes, shows and samples simulated laboratories.
#include <algorithm>

#include "palpate/core/child_report.h"
#include "palpate/core/file.h"
#include "palpate/core/stop_signal.h"
#include "palpate/evaluation/world_sample.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/sim/world_process.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/guests.h"
#include "tools/commands/settings_options.h"

namespace palpate::tools::commands {
namespace {

struct WorldOptions {
  std::string file, kind, out, name = "lab", exposures, trace;
  double seconds = 0.0;
  std::uint64_t seed = 1;
  int points = 0;
  bool continuous = false, guided = false, arm_only = false, gestures = false;
};

Expected<sim::config::WorldFile> world_from(const std::string& file) {
  return world_of(file, known_applications());
}

const std::vector<std::pair<std::string, evaluation::SampleKind>> kKinds = {
    {"pivot", evaluation::SampleKind::pivot},        {"arm", evaluation::SampleKind::arm},
    {"hand-eye", evaluation::SampleKind::hand_eye},  {"camera", evaluation::SampleKind::camera},
    {"pointer", evaluation::SampleKind::pointer},    {"surface", evaluation::SampleKind::surface},
    {"landmarks", evaluation::SampleKind::landmarks}};

std::vector<std::string> kind_names() {
  std::vector<std::string> names;
  for (const auto& [name, kind] : kKinds) names.push_back(name);
  return names;
}

Expected<void> sample_into_folder(const WorldOptions& options) {
  const auto file = world_from(options.file);
  if (!file) return tl::unexpected(file.error());
  evaluation::SampleRequest request;
  request.seed = options.seed;
  request.points = options.points;
  request.continuous = options.continuous;
  request.kind = std::find_if(kKinds.begin(), kKinds.end(), [&](const auto& known) {
                   return known.first == options.kind;
                 })->second;
  if (request.continuous && request.kind != evaluation::SampleKind::arm)
    return wrong_use("--continuous: goes with arm, not with {}", options.kind);
  request.guided = options.guided;
  if (request.guided && (request.kind != evaluation::SampleKind::arm || request.continuous))
    return wrong_use("--guided: goes with arm in held poses, not with {}",
                     request.continuous ? "--continuous" : options.kind);
  const bool replaces = is_there(std::filesystem::path(options.out) / "truth.json");
  const auto written = evaluation::sample_world(*file, request, options.out);
  if (!written) return tl::unexpected(written.error());
  for (const auto& path : *written) print_line(path.string());
  if (replaces)
    notice(fmt::format("{}: replaced the truth of an earlier sample; a folder each keeps both",
                       written->back().string()));
  return {};
}

Expected<void> write_reference(const WorldOptions& options) {
  if (options.file != "-" && is_there(options.file))
    return wrong_use("{}: exists already; name a new file, or remove it first", options.file);
  return write_file(options.file, sim::config::reference_world_text());
}

Expected<void> show_world(const WorldOptions& options) {
  const auto file = world_from(options.file);
  if (!file) return tl::unexpected(file.error());
  return write_file("-", sim::config::world_text(*file));
}

Expected<void> run_laboratory(const WorldOptions& options) {
  const auto file = world_from(options.file);
  if (!file) return tl::unexpected(file.error());
  sim::WorldProcessOptions process;
  process.name = options.name;
  process.seed = options.seed;
  process.seconds = options.seconds;
  process.exposures = options.exposures;
  process.trace = options.trace;
  if (!options.arm_only)
    process.make_renderer = []() -> sim::RenderView {
      auto renderer = std::make_shared<sim::CameraRenderer>();
      return [renderer](const sim::TrueView& view, std::vector<std::uint8_t>& rgb) {
        renderer->render(view, rgb);
      };
    };
  process.ready = tell_parent_ready;
  process.gestures = options.gestures;
  const auto report = sim::run_world(*file, process, stop_requested());
  if (!report) return tl::unexpected(report.error());
  fmt::print("{} ticks, {} late by more than 1 ms, worst {:.1f} ms; {} pictures\n", report->ticks,
             report->late_ticks, report->worst_late_s * 1e3, report->images);
  return {};
}

void add_sample(CLI::App& world, const std::shared_ptr<WorldOptions>& options) {
  auto* sample =
      world.add_subcommand("sample", "Write what the devices would have recorded, and the truth beside it");
  sample->add_option("kind", options->kind, "What is recorded")->required()->check(one_of(kind_names()));
  sample->add_option("--world", options->file, "World file; the reference world where none is named");
  sample->add_option("--seed", options->seed, "Draws everything called sd, and all noise")
      ->capture_default_str();
  sample
      ->add_option("--points", options->points,
                   "Poses, images or touches (default: pivot and pointer 400, arm 140, hand-eye 600, camera "
                   "15, surface 4, landmarks one each)")
      ->check(between(1, 100000));
  sample->add_flag("--continuous", options->continuous, "arm: record while the stylus moves freely");
  sample->add_flag("--guided", options->guided,
                   "arm: show the person where the next pose helps the calibration most");
  sample->add_option("--out", options->out, "Folder for the files; those of an earlier sample are replaced")
      ->required();
  on(sample, [options] { return sample_into_folder(*options); });
}

void add_run(CLI::App& world, const std::shared_ptr<WorldOptions>& options) {
  auto* run =
      world.add_subcommand("run", "Run the laboratory in real time, its devices open to the two servers");
  run->add_option("--world", options->file, "World file; the reference world where none is named");
  run->add_option("--seed", options->seed, "Draws everything called sd, and all noise")
      ->capture_default_str();
  run->add_option("--name", options->name, "Name under which the servers find this laboratory")
      ->capture_default_str();
  run->add_flag("--arm-only", options->arm_only,
                "Draw no pictures: for a rig whose camera is real and whose arm is the mouse");
  run->add_flag(
      "--gestures", options->gestures,
      "The person in it does what lines of JSON on standard input say, as `calibrate all --instructions` "
      "writes them");
  run->add_option("--seconds", options->seconds,
                  "Stop by itself after this time (default: run until stopped)")
      ->check(at_least_zero());
  run->add_option(
      "--exposures", options->exposures,
      "CSV file to write at the end: when each image was taken, on the machine's monotonic clock, and where "
      "camera and stylus tip truly were then");
  run->add_option("--trace", options->trace,
                  "Write when the camera's images were drawn, to open in Perfetto beside that of `palpate "
                  "graphics --trace`")
      ->type_name("FILE.json");
  on(run, [options] { return run_laboratory(*options); });
}

}  // namespace

void add_world(CLI::App& program) {
  auto options = std::make_shared<WorldOptions>();
  auto* world = program.add_subcommand("world", "The simulated laboratory: make, show, sample, run");
  world->require_subcommand(1);

  auto* make = world->add_subcommand("new", "Write the reference world to a file to be changed");
  make->add_option("file", options->file, "File to write; must not exist (- is standard output)")->required();
  on(make, [options] { return write_reference(*options); });

  auto* show =
      world->add_subcommand("show", "Check a world file and print all its values, defaults filled in");
  show->add_option("file", options->file, "World file; the reference world where none is named");
  on(show, [options] { return show_world(*options); });

  add_sample(*world, options);
  add_run(*world, options);
}

}  // namespace palpate::tools::commands
