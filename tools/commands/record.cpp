// palpate record: a session's states, and what tracker and camera measure, into one file, beside whatever runs.
#include <fmt/format.h>

#include <memory>

#include "palpate/core/child_report.h"
#include "palpate/core/json.h"
#include "palpate/core/text.h"
#include "palpate/server/session/side_recording.h"
#include "tools/commands/camera_options.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/drivers.h"
#include "tools/commands/record_options.h"
#include "tools/commands/server_options.h"

namespace palpate::tools::commands {
namespace {

struct SideRecordArguments {
  server::session::SideRecordingOptions side;
  std::string tracker, camera, json;
  std::vector<std::string> tools;
  CameraOptions camera_options;
  RecordOptions record;
};

Expected<void> record_session(SideRecordArguments& options) {
  auto& side = options.side;
  side.drivers = drivers();
  side.out = options.record.file;
  auto pictures = picture_recording(options.record);
  if (!pictures) return tl::unexpected(pictures.error());
  if (pictures->wanted() && options.camera.empty())
    return wrong_use("--pictures {}: goes with --camera", options.record.pictures);
  side.pictures = std::move(*pictures);
  if (!options.tracker.empty()) {
    side.tracker = device::TrackerRequest{options.tracker, options.tools};
    if (auto fine = side.drivers.check(*side.tracker); !fine)
      return wrong_use("--tracker: {}", fine.error().message);
  }
  if (!options.camera.empty()) {
    side.camera = device::CameraRequest{options.camera, {}};
    if (side.drivers.names_camera(options.camera, device::Offer::real)) {
      auto request = camera_request(side.drivers, options.camera, options.camera_options);
      if (!request) return tl::unexpected(request.error());
      side.camera = *request;
    }
  }
  side.ready = tell_parent_ready;
  const auto figures = server::session::record_beside(side);
  if (!figures) return tl::unexpected(figures.error());
  tell_parent_result(*figures);
  if (!options.json.empty()) return write_json(options.json, *figures);
  print_line(fmt::format("{}: {:.1f} s, {} messages, {:.1f} MB", one_line(side.out.string()),
                         (*figures)["seconds"].get<double>(), (*figures)["messages"].get<std::uint64_t>(),
                         (*figures)["bytes"].get<double>() * 1e-6));
  return {};
}

}  // namespace

void add_record(CLI::App& program) {
  auto options = std::make_shared<SideRecordArguments>();
  auto* command = program.add_subcommand("record",
                                         "Record beside a running session: its world's states, and a tracker "
                                         "and a camera that others may read, too");
  command->add_option("--out", options->record.file, "New file (MCAP)")->required()->type_name("FILE");
  add_server_options(*command, options->side.server);
  command->add_option("--rate-hz", options->side.rate_hz, "Of the states")
      ->check(between(1, 1000))
      ->capture_default_str();
  command->add_option("--tracker", options->tracker, "A tracker: " + drivers().tracker_forms())
      ->type_name("URI");
  command->add_option("--tracker-tool", options->tools,
                      "What the tracker calls a marker: tip_marker=NAME, camera_marker=NAME, pointer=NAME");
  command->add_option("--camera", options->camera, "A camera: " + drivers().camera_forms())->type_name("URI");
  add_camera_options(*command, options->camera_options);
  add_picture_option(*command, options->record);
  command->add_option("--seconds", options->side.seconds, "Stop after this many seconds; 0 = at Ctrl-C")
      ->check(at_least_zero())
      ->default_val(0.0);
  command->add_option("--json", options->json, "Write the figures here at the end; - = standard output");
  on(command, [options] { return record_session(*options); });
}

}  // namespace palpate::tools::commands
