#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <tuple>

#include "drivers/openigtlink/protocol.h"
#include "drivers/vrpn/protocol.h"
#include "palpate/core/child_report.h"
#include "palpate/core/file.h"
#include "palpate/core/json.h"
#include "palpate/core/text.h"
#include "palpate/rig/doubtful_values.h"
#include "palpate/server/graphics/real_objects.h"
#include "palpate/server/session/graphics_process.h"
#include "palpate/sim/lockstep/lockstep_play.h"
#include "tools/commands/camera_options.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/drivers.h"
#include "tools/commands/guests.h"
#include "tools/commands/record_options.h"
#include "tools/commands/server_options.h"
#include "tools/commands/settings_options.h"

namespace palpate::tools::commands {
namespace {

struct GraphicsOptions {
  std::string rig = "rig.toml", world, json, tracker, camera = "lab", right_camera, quality = "auto",
              hand = "none", lab = "lab";
  CameraOptions camera_options;
  RecordOptions record;
  std::vector<std::string> tools;
  std::string picture_time, monitor;
  double headset_distance = 0.0, scan_out_ms = 0.0, extra_delay_ms = 0.0;
  // One of each protocol: where its poses are served, an empty text: at its own port.
  std::optional<std::string> igtl_publish, vrpn_publish;
  bool igtl_insecure = false, vrpn_insecure = false, scan_out_said = false, extra_delay_said = false,
       headset_distance_said = false;
  server::session::GraphicsProcessOptions process;
};

// --igtl-publish and --igtl-insecure, of whichever protocol.
void add_publishing(CLI::App& command, const std::string& word, const char* by, std::uint16_t port,
                    std::optional<std::string>& place, bool& insecure) {
  command
      .add_option(
          "--" + word + "-publish",
          [&place](const CLI::results_t& said) {
            place = said.empty() ? std::string() : said.front();
            return true;
          },
          fmt::format("Serve live poses over {} at [HOST:]PORT; {} where none is said", by, port))
      ->type_name("ADDRESS")
      ->expected(0, 1);
  command.add_flag("--" + word + "-insecure", insecure,
                   "Serve poses beyond this machine: the protocol protects nothing");
}

void add_device_options(CLI::App& command, GraphicsOptions& options) {
  command.add_option("--rig", options.rig, "Calibrated rig file")->capture_default_str();
  add_server_options(command, options.process.server);
  command.add_option("--lab", options.lab, "Name of the laboratory `palpate world run` serves")
      ->default_val("lab");
  command
      .add_option("--camera", options.camera,
                  "lab (of a simulated laboratory), or a real camera or recording: " +
                      drivers().camera_forms(device::Offer::real))
      ->type_name("CAMERA")
      ->default_val("lab");
  command
      .add_option("--right-camera", options.right_camera,
                  "A second real camera on the same marker, for the right eye; it must expose at the same "
                  "moments as --camera, and the rig have both calibrated")
      ->type_name("CAMERA");
  add_camera_options(command, options.camera_options);
  command
      .add_option("--tracker", options.tracker,
                  "igtl://HOST:PORT or vrpn://HOST:PORT: the tracker of an OpenIGTLink or VRPN server; "
                  "ndi://HOST[:PORT][/FILE.rom,...]: an NDI tracker; instead of the laboratory's")
      ->type_name("ADDRESS");
  command
      .add_option("--tracker-tool", options.tools,
                  "What that server calls a marker, where it is not CameraMarkerToWorld and so on: "
                  "camera_marker, tip_marker "
                  "or pointer; several may be named")
      ->type_name("MARKER=NAME")
      ->expected(1)
      ->take_all();
  add_publishing(command, "igtl", "OpenIGTLink, for 3D Slicer", drivers::openigtlink::kProtocol.default_port,
                 options.igtl_publish, options.igtl_insecure);
  add_publishing(command, "vrpn", "VRPN", drivers::vrpn::kProtocol.default_port, options.vrpn_publish,
                 options.vrpn_insecure);
}

void add_picture_options(CLI::App& command, GraphicsOptions& options) {
  command.add_option(
      "--mesh", options.process.mesh,
      "The mesh file that the application uses, where it is not on the physics server's machine");
  command
      .add_option(
          "--hand", options.hand,
          "The hand that holds the arm's stylus and that the camera sees: right or left; virtual things "
          "behind it are not drawn over it")
      ->capture_default_str();
  command
      .add_option("--quality", options.quality,
                  "Of the picture: low, medium, high, or auto: by what is missed")
      ->capture_default_str();
  command.add_flag("--player", options.process.player, "Let the scripted player hold the stylus");
  auto* window = command.add_flag(
      "--window", options.process.window,
      "Show the picture in a window, with sound; ? lists its keys. Without, nothing is shown");
  command
      .add_flag("--mouse", options.process.mouse,
                "Let the mouse hold the stylus; with --player, from its first movement on")
      ->needs(window);
  command
      .add_option("--monitor", options.monitor,
                  "A second window for those who look on: copy (what the first shows) or outside (the play "
                  "from the side)")
      ->type_name("VIEW")
      ->needs(window);
  command
      .add_flag("--biocular", options.process.biocular,
                "Show the camera's picture twice, side by side, for a head-mounted display")
      ->needs(window);
  auto* headset = command.add_flag("--headset", options.process.headset,
                                   "Show the picture in the headset of this machine's OpenXR runtime, with "
                                   "score and warnings; beside a window or "
                                   "without one");
  command
      .add_option(
          "--headset-distance-m", options.headset_distance,
          "Where shifts of the head are corrected: at this distance from the camera, instead of that of the "
          "stylus' tip")
      ->check(between(0.1, 100.0))
      ->needs(headset);
  command.add_flag("--clock-strip", options.process.timecode,
                   "Measure the delay from light to light: show the clock strip on the simulated display, or "
                   "with a real camera in the window, at which the camera then has to look");
}

void add_run_options(CLI::App& command, GraphicsOptions& options) {
  command
      .add_option("--trace", options.process.trace,
                  "Write where each frame's time goes, in stages, to open in Perfetto or chrome://tracing")
      ->type_name("FILE.json");
  command.add_option("--world", options.world,
                     "World file of that laboratory: how a player's hand and arm feel, the mouse's too");
  command.add_option("--seed", options.process.seed, "Seed of the scripted player")->default_val(1);
  command
      .add_option("--seconds", options.process.seconds,
                  "Stop after this many seconds; 0 = at Ctrl-C or when the window is closed")
      ->check(at_least_zero())
      ->default_val(0.0);
  command
      .add_option(
          "--wait-s", options.process.wait_s,
          "How long to wait for the physics server's first answer; it may have to prepare what it plays")
      ->check(at_least_zero())
      ->default_val(options.process.wait_s);
  command.add_option("--out", options.process.out,
                     "Folder for what was measured frame by frame (realtime_*.csv), in place at the end");
  add_record_options(command, options.record);
  command.add_option("--json", options.json,
                     "Write exchange and clock figures here at the end; - = standard output");
}

void add_delay_options(CLI::App& command, GraphicsOptions& options) {
  command
      .add_option("--picture-time", options.picture_time,
                  "registered: virtual things as they were when the image was taken; predicted: as they "
                  "will be when the picture is seen. As the world file says where none is named")
      ->check(one_of({"registered", "predicted"}));
  command
      .add_option("--scan-out-ms", options.scan_out_ms,
                  "From the end of drawing until the display shows the picture's middle")
      ->check(between(0.0, 1000.0));
  command
      .add_option("--extra-picture-delay-ms", options.extra_delay_ms,
                  "Hold every image back by so much, on purpose: for experiments")
      ->check(between(0.0, 1000.0));
  command
      .add_option("--disguise-offset-s", options.process.disguise_offset_s,
                  "Show this machine's clock with an offset, to try the clock synchronisation")
      ->default_val(0.0);
  command.add_option("--disguise-drift-ppm", options.process.disguise_drift_ppm, "... and with a drift")
      ->default_val(0.0);
}

Expected<void> choose_tracker(GraphicsOptions& options) {
  using By = server::graphics::PublishAt::By;
  for (const auto& [by, protocol, place, insecure, flag] :
       {std::tuple{By::openigtlink, drivers::openigtlink::kProtocol, &options.igtl_publish,
                   options.igtl_insecure, "--igtl-insecure"},
        {By::vrpn, drivers::vrpn::kProtocol, &options.vrpn_publish, options.vrpn_insecure,
         "--vrpn-insecure"}}) {
    if (!*place) continue;
    const std::string where = (*place)->empty() ? std::to_string(protocol.default_port) : **place;
    const auto address = drivers::network::parse_listen(where, protocol, insecure, flag);
    if (!address) return tl::unexpected(address.error());
    options.process.publish.push_back({by, *address});
    if (insecure)
      notice(fmt::format(
          "warning: poses over {} are neither encrypted nor guarded: anyone who reaches them sees them",
          protocol.name));
  }
  if (!options.tracker.empty()) {
    if (!drivers().names_tracker(options.tracker, device::Offer::real))
      return wrong_use("'{}': {} is expected", excerpt(options.tracker, 100),
                       drivers().tracker_forms(device::Offer::real));
    options.process.tracker = device::TrackerRequest{options.tracker, options.tools};
    if (auto fine = drivers().check(*options.process.tracker); !fine) return fine;
  } else if (!options.tools.empty()) {
    return wrong_use(
        "--tracker-tool names tools of the server at --tracker igtl://HOST:PORT, vrpn://HOST:PORT or "
        "ndi://HOST:PORT; say which");
  }
  return {};
}

Expected<void> choose_camera(GraphicsOptions& options) {
  if (options.camera != "lab") {
    if (!drivers().names_camera(options.camera, device::Offer::real))
      return wrong_use("--camera: is '{}'; {} is expected", excerpt(options.camera, 100),
                       drivers().camera_forms());
    auto request = camera_request(drivers(), options.camera, options.camera_options);
    if (!request) return tl::unexpected(request.error());
    options.process.camera = *request;
  }
  if (options.process.timecode && options.process.camera) {
    if (drivers().find_for(options.camera)->recording)
      return wrong_use(
          "--clock-strip: --camera is {}, which cannot look at this screen; lab, aravis or v4l2 is "
          "expected",
          excerpt(options.camera, 100));
    if (!options.process.window)
      return wrong_use("--clock-strip: with --camera {} it is shown in the window; add --window",
                       excerpt(options.camera, 100));
  }
  return {};
}

Expected<void> choose_picture(GraphicsOptions& options) {
  if (!options.monitor.empty()) {
    const auto view = desktop::parse_monitor_view(options.monitor);
    if (!view) return tl::unexpected(view.error());
    options.process.monitor = *view;
  }
  if (options.headset_distance_said) options.process.headset_distance = options.headset_distance;
  if (options.process.headset && options.process.biocular)
    return wrong_use("--biocular: a headset shows each eye its picture by itself; leave it out");
  const auto quality = render::parse_quality_choice(options.quality);
  if (!quality) return tl::unexpected(quality.error());
  options.process.quality = *quality;
  const auto hands = device::holding_hand_words();
  if (std::find(hands.begin(), hands.end(), options.hand) == hands.end())
    return wrong_use("--hand '{}': none, right or left is expected", excerpt(options.hand));
  options.process.hand = device::holding_hand_of(options.hand);
  return {};
}

// The rig has what this way of running needs, and no option contradicts it.
Expected<void> check_rig(const GraphicsOptions& options, const rig::Rig& rig) {
  if (auto objects = server::graphics::RealObjects::read(rig); !objects)
    return tl::unexpected(objects.error());
  // With such a delay it asks for states that nobody has.
  for (const auto& doubt : rig::doubtful_values(rig))
    if (doubt.part == "delays") return refused("{}: {}: {}", options.rig, doubt.part, doubt.what);
  if (rig.board) {
    if (const auto missing = rig::missing_parts(rig); !missing.empty())
      return refused("{}: lacks {}; {}", options.rig, missing.front().part, missing.front().remedy);
    if (options.camera == "lab")
      return wrong_use("--camera: the rig of {} reads its camera's place off a printed board; name one of {}",
                       options.rig, drivers().camera_forms(device::Offer::real));
    if (!options.tracker.empty())
      return wrong_use("--tracker: the rig of {} has a printed board instead; leave it out", options.rig);
    if (options.picture_time == "predicted")
      return wrong_use(
          "--picture-time predicted: needs a tracker, which sees the head between pictures; "
          "with a printed board registered is expected");
  } else if (!rig.arm || !rig.camera || !rig.hand_eye) {
    return refused(
        "{}: arm, camera or hand-eye calibration is missing; run `palpate calibrate all --arm URI --tracker "
        "URI "
        "--camera URI --rig {}` (without the three: for the simulated laboratory)",
        options.rig, options.rig);
  }
  return {};
}

Expected<void> choose_eyes(GraphicsOptions& options, const rig::Rig& rig) {
  if (!options.right_camera.empty()) {
    if (options.camera == "lab")
      return wrong_use(
          "--right-camera: goes beside a real one; name that with --camera (a laboratory's second "
          "camera is found by itself)");
    if (rig.board)
      return wrong_use("--right-camera: the rig of {} has a printed board, which goes with one camera",
                       options.rig);
    auto request = camera_request(drivers(), options.right_camera, options.camera_options);
    if (!request) return tl::unexpected(request.error());
    options.process.right_camera = *request;
    if (!rig::has_two_eyes(rig))
      return refused(
          "{}: the right camera is not calibrated; run `palpate calibrate camera --camera right` and "
          "`palpate calibrate hand-eye --camera right`",
          options.rig);
  }
  if (options.process.biocular && rig::has_two_eyes(rig))
    return wrong_use(
        "--biocular: the rig of {} has two cameras, one for each eye, and shows their pictures side by "
        "side; one camera is expected: leave it out",
        options.rig);
  return {};
}

Expected<void> choose_times(GraphicsOptions& options, const rig::Rig& rig) {
  auto world = world_of(options.world, options.process.applications);
  if (!world) return tl::unexpected(world.error());
  options.process.world = std::move(*world);
  auto& graphics = options.process.graphics;
  graphics = sim::lockstep::graphics_settings(options.process.world);
  if (!options.picture_time.empty())
    graphics.picture_time = options.picture_time == "predicted" ? server::graphics::PictureTime::predicted
                                                                : server::graphics::PictureTime::registered;
  if (rig.board) graphics.picture_time = server::graphics::PictureTime::registered;
  if (options.scan_out_said) graphics.scan_out = seconds(1e-3 * options.scan_out_ms);
  if (options.extra_delay_said) graphics.extra_delay = seconds(1e-3 * options.extra_delay_ms);
  return {};
}

Expected<void> run_graphics(GraphicsOptions& options) {
  if (auto chosen = choose_tracker(options); !chosen) return chosen;
  if (auto chosen = choose_camera(options); !chosen) return chosen;
  if (auto chosen = choose_picture(options); !chosen) return chosen;
  auto rig = rig::read_rig(options.rig);
  if (!rig) return tl::unexpected(rig.error());
  if (auto fine = check_rig(options, *rig); !fine) return fine;
  if (options.process.mouse || options.process.player)  // who move the laboratory's arm
    if (auto there = laboratory_of_desk(*rig, options.rig, options.lab); !there) return there;
  if (auto chosen = choose_eyes(options, *rig); !chosen) return chosen;
  options.process.rig_text = read_file(options.rig).value_or("");
  options.process.rig = *rig;
  options.process.applications = known_applications();
  options.process.drivers = drivers();
  auto pictures = picture_recording(options.record);
  if (!pictures) return tl::unexpected(pictures.error());
  options.process.record = options.record.file;
  options.process.record_pictures = std::move(*pictures);
  options.process.stand_in = "lab:" + options.lab;
  if (auto chosen = choose_times(options, *rig); !chosen) return chosen;
  if (!options.process.out.empty())  // now, not after an hour of play
    if (auto made = make_folder(options.process.out); !made) return made;
  options.process.ready = tell_parent_ready;
  auto result = server::session::run_graphics_process(options.process);
  if (!result && !options.tracker.empty() && options.camera == "lab" &&
      result.error().message.starts_with("laboratory"))
    return tl::unexpected(Error{
        result.error().kind, result.error().message + "; --camera names another camera than the laboratory's",
        result.error().code});
  if (!result) return tl::unexpected(result.error());
  tell_parent_result(*result);
  if (!options.json.empty()) return write_json(options.json, *result);
  fmt::print("{} frames at {:.1f} Hz, {} late; round trip {:.0f} us median\n",
             (*result)["exchange"]["frames"].get<std::uint64_t>(),
             (*result)["graphics"]["rate_hz"].get<double>(),
             (*result)["exchange"]["late"].get<std::uint64_t>(),
             (*result)["exchange"]["round_trip_us"]["median"].get<double>());
  return {};
}

}  // namespace

void add_graphics(CLI::App& program) {
  auto* command =
      program.add_subcommand("graphics", "The graphics server: camera and tracker in, augmented picture out");
  auto options = std::make_shared<GraphicsOptions>();
  add_device_options(*command, *options);
  add_picture_options(*command, *options);
  add_run_options(*command, *options);
  add_delay_options(*command, *options);
  on(command, [options, command] {
    options->scan_out_said = command->count("--scan-out-ms") > 0;
    options->headset_distance_said = command->count("--headset-distance-m") > 0;
    options->extra_delay_said = command->count("--extra-picture-delay-ms") > 0;
    return run_graphics(*options);
  });
}

}  // namespace palpate::tools::commands
