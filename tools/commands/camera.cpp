#include <fmt/format.h>

#include <thread>

#include "palpate/core/csv_file.h"
#include "palpate/core/file.h"
#include "palpate/core/json.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/text.h"
#include "palpate/device/health_monitor.h"
#include "palpate/device/recorded_images.h"
#include "palpate/render/picture_file.h"
#include "palpate/time/clock.h"
#include "tools/commands/camera_options.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/drivers.h"

namespace palpate::tools::commands {
namespace {

Expected<void> list_cameras(const std::string& json) {
  std::vector<device::FoundCamera> found;
  for (const auto& driver : drivers().drivers())
    if (driver.find_cameras)
      for (auto& camera : driver.find_cameras()) found.push_back(std::move(camera));
  if (!json.empty()) {
    Json list = Json::array();
    for (const auto& camera : found) list.push_back(camera.facts);
    return write_json(json, {{"cameras", list}});
  }
  for (const auto& camera : found) print_line(camera.line);
  if (found.empty())
    fmt::print(
        "no camera: none at /dev/video*, and none answers in the network or at USB; palpate doctor says "
        "more\n");
  return {};
}

struct RecordArguments {
  std::string camera, out, size;
  CameraOptions options;
  double seconds = 10.0, every_s = 0.0;
};

Expected<void> record(const RecordArguments& arguments) {
  auto request = camera_request(drivers(), arguments.camera, arguments.options);
  if (!request) return tl::unexpected(request.error());
  if (!arguments.size.empty()) {
    int width = 0, height = 0;
    char rest = 0;
    if (std::sscanf(arguments.size.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 16 ||
        height < 16 || width > 20000 || height > 20000)
      return wrong_use("--size-px '{}': WIDTHxHEIGHT is expected, such as 640x480", excerpt(arguments.size));
    request->settings.width = width, request->settings.height = height;
  }
  const std::filesystem::path folder = arguments.out;
  std::error_code ignored;
  if (std::filesystem::exists(folder / device::kStampsFile, ignored))
    return wrong_use("{}: holds a recording already; name another folder", arguments.out);
  const auto& stop = stop_requested();
  auto camera = drivers().open(*request);
  if (!camera) return tl::unexpected(camera.error());
  if (auto made = make_folder(folder); !made) return made;
  auto stamps = CsvFile::begin(folder / device::kStampsFile, {"image", "time_s", "frame"});
  if (!stamps) return tl::unexpected(stamps.error());
  notice(fmt::format("camera {}: {}", (*camera)->name(), (*camera)->description()));
  const MonotonicClock<GraphicsClock> clock;
  const auto begun = clock.now();
  device::HealthMonitor<GraphicsClock> health{Log()};
  std::uint64_t written = 0;
  std::optional<std::int64_t> last_ns;
  std::uint64_t last_frame = 0;
  bool ended = false;
  while (!stop.load() && !ended &&
         (arguments.seconds <= 0.0 || to_seconds(clock.now() - begun) < arguments.seconds)) {
    auto image = (*camera)->device().poll();
    if (auto there = (*camera)->look(); !there) return there;
    health.follow((*camera)->health(), clock.now());
    ended = (*camera)->ended() && !image;
    if (!image) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      continue;
    }
    const std::int64_t ns = image->mid_exposure.ns();
    if (last_ns && 1e-9 * static_cast<double>(ns - *last_ns) < arguments.every_s) continue;
    if (last_ns && (ns <= *last_ns || image->frame <= last_frame))
      return refused(
          "camera {}: its clock or count began anew after {}; what was recorded so far has no table, record "
          "again",
          (*camera)->name(), counted(written, "image"));
    const std::string name = fmt::format("image_{:06}.png", ++written);
    if (auto done = render::write_png(folder / name, image->rgb, image->width, image->height); !done)
      return done;
    stamps->row(std::vector<std::string>{name, device::stamp_text(ns), std::to_string(image->frame)});
    last_ns = ns, last_frame = image->frame;
  }
  if (written == 0)
    return refused("camera {}: no picture came in {:.1f} s; {}", (*camera)->name(),
                   to_seconds(clock.now() - begun), "see to its cable, or record for longer");
  if (auto done = stamps->finish(); !done) return done;
  fmt::print("{} in {}; {} dropped by the camera, {} damaged\n", counted(written, "image"),
             one_line(arguments.out), (*camera)->figures()["dropped"].get<std::uint64_t>(),
             (*camera)->figures()["damaged"].get<std::uint64_t>());
  return {};
}

}  // namespace

void add_camera(CLI::App& program) {
  auto* camera =
      program.add_subcommand("camera", "Real cameras: which there are, and pictures of them in a folder");
  camera->require_subcommand(1);

  auto* list = camera->add_subcommand(
      "list", "The cameras that answer: GenICam ones (asked for a second) and /dev/video*");
  auto json = std::make_shared<std::string>();
  list->add_option("--json", *json, "Write them as JSON to FILE (- = standard output, instead of lines)")
      ->type_name("FILE");
  on(list, [json] { return list_cameras(*json); });

  auto* take = camera->add_subcommand(
      "record",
      "Save pictures with their times, for `palpate calibrate camera --images 'FOLDER/*.png'` and "
      "`palpate graphics --camera images:FOLDER`");
  auto arguments = std::make_shared<RecordArguments>();
  take->add_option("camera", arguments->camera, drivers().camera_forms(device::Offer::real))
      ->required()
      ->type_name("CAMERA");
  take->add_option("--out", arguments->out, "Folder for image_*.png and stamps.csv")
      ->required()
      ->type_name("FOLDER");
  take->add_option("--seconds", arguments->seconds, "Stop after this many seconds; 0 = at Ctrl-C")
      ->check(at_least_zero())
      ->default_val(10.0);
  take->add_option("--every-s", arguments->every_s, "Time between pictures that are kept; 0 = all")
      ->check(at_least_zero())
      ->default_val(0.0);
  take->add_option("--size-px", arguments->size, "Set the camera to this size")->type_name("640x480");
  add_camera_options(*take, arguments->options);
  on(take, [arguments] { return record(*arguments); });
}

}  // namespace palpate::tools::commands
