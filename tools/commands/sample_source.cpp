#include "tools/commands/sample_source.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <utility>

#include "palpate/calibration/session/reference_body.h"
#include "palpate/calibration/session/stream_tables.h"
#include "palpate/core/file.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/text.h"
#include "palpate/core/units.h"
#include "palpate/device/marker_names.h"
#include "palpate/record/session/recorded_arm.h"
#include "palpate/record/session/recorded_streams.h"
#include "palpate/record/session/session_recording.h"
#include "palpate/time/clock.h"
#include "tools/commands/checks.h"
#include "tools/commands/command.h"
#include "tools/commands/drivers.h"

namespace palpate::tools::commands {
namespace {

namespace session = calibration::session;

constexpr double kLongestSample = 3600.0;  // s; an arm's millisecond takes 200 bytes of memory

struct SampledDevices {
  std::unique_ptr<device::OpenedArm> arm;
  std::unique_ptr<device::OpenedTracker> tracker;
  std::unique_ptr<device::OpenedCamera> camera;

  Expected<void> look() {
    if (arm)
      if (auto there = arm->look(); !there) return there;
    if (tracker)
      if (auto there = tracker->look(); !there) return there;
    if (camera) return camera->look();
    return {};
  }
};

Expected<SampledDevices> open_sampled(const SampleArguments& options, const rig::Rig& rig,
                                      const device::DriverRegistry& known) {
  SampledDevices opened;
  if (!options.arm.empty()) {
    auto arm = known.open(device::ArmRequest{
        .uri = options.arm, .nominal = rig.nominal_arm, .at_reset_position = options.at_reset});
    if (!arm) return tl::unexpected(arm.error());
    opened.arm = std::move(*arm);
    if (const int joints = opened.arm->facts().joints; joints != 3)
      return refused("--arm {}: has {} joints; samples are taken of arms with three", options.arm, joints);
    const bool place = rig.nominal_arm.kind == device::ArmModel::Kind::cartesian;
    if (opened.arm->facts().states_place != place)
      return refused(
          "--arm {}: {}, and the arm {}{} {}; a rig with this arm is expected (palpate rig new FILE "
          "--arm ARM, then --rig FILE)",
          options.arm, place ? "has joints" : "states its place", rig.nominal_arm.name,
          options.rig.empty() ? ", as long as no --rig names another," : " of the rig",
          place ? "states its place" : "has joints");
  }
  if (!options.tracker.empty()) {
    auto tracker = known.open(device::TrackerRequest{options.tracker, options.tracker_tools});
    if (!tracker) return tl::unexpected(tracker.error());
    opened.tracker = std::move(*tracker);
  }
  if (!options.camera.empty()) {
    auto camera = open_camera(drivers(), known, options.camera, options.camera_options);
    if (!camera) return tl::unexpected(camera.error());
    opened.camera = std::move(*camera);
  }
  return opened;
}

// What the devices say goes into a recording as well, where one is asked for.
struct SampleRecording {
  std::unique_ptr<record::session::SessionRecording> recording;
  device::DriverRegistry drivers;
};

Expected<SampleRecording> begin_sample_recording(const RecordOptions& options) {
  const auto pictures = picture_recording(options);
  if (!pictures) return tl::unexpected(pictures.error());
  if (options.file.empty()) return SampleRecording{nullptr, drivers()};
  auto begun = record::session::SessionRecording::begin(options.file, {.recorder = "sample", .on_error = {}});
  if (!begun) return tl::unexpected(begun.error());
  SampleRecording made{std::move(*begun), {}};
  made.drivers = record::session::recorded_drivers(drivers(), *made.recording, *pictures);
  return made;
}

// Lines of standard input, as moments.
class MarkedMoments {
 public:
  explicit MarkedMoments(bool wanted) : open_(wanted) {}
  void look(double now_s, std::vector<double>& moments) {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    while (open_ && poll(&input, 1, 0) > 0) {
      char bytes[64];
      const auto count = read(STDIN_FILENO, bytes, sizeof bytes);
      if (count <= 0) open_ = false;
      for (ssize_t i = 0; i < count; ++i)
        if (bytes[i] == '\n') moments.push_back(now_s);
    }
  }

 private:
  bool open_;
};

// A line that is written over, on a terminal only.
class SampleProgress {
 public:
  void show(const std::string& line, double elapsed_s) {
    if (!terminal_ || elapsed_s < next_s_) return;
    next_s_ = elapsed_s + 0.25;
    std::fprintf(stderr, "\r\x1b[K%s", excerpt(line, 160).c_str());
    shown_ = true;
  }
  ~SampleProgress() {
    if (shown_) std::fprintf(stderr, "\r\x1b[K");
  }

 private:
  const bool terminal_ = isatty(STDERR_FILENO) != 0;
  bool shown_ = false;
  double next_s_ = 0.0;
};

// Counts that grow with the samples; nothing is gone through again for a line.
class SampleCounts {
 public:
  void add(const device::TrackerSample& sample) {
    auto& [seen, hidden] = markers_[sample.marker];
    ++(sample.seen ? seen : hidden);
  }
  void add_arm() { ++arm_; }
  std::string line(double elapsed_s) const {
    std::string text = fmt::format("{:.1f} s", elapsed_s);
    if (arm_ > 0) text += fmt::format("  arm {}", arm_);
    for (const auto& [marker, counts] : markers_)
      text +=
          fmt::format("  {} {} seen, {} hidden", device::name_of_marker(marker), counts.first, counts.second);
    return text;
  }

 private:
  std::size_t arm_ = 0;
  std::map<device::MarkerId, std::pair<std::size_t, std::size_t>> markers_;
};

Expected<TakenSamples> from_devices(const SampleArguments& options, const SampleNeeds& needs,
                                    const rig::Rig& rig) {
  const auto& stop = stop_requested();
  auto recording = begin_sample_recording(options.record);
  if (!recording) return tl::unexpected(recording.error());
  auto opened = open_sampled(options, rig, recording->drivers);
  if (!opened) return tl::unexpected(opened.error());
  TakenSamples taken;
  taken.source = !options.tracker.empty() ? options.tracker : options.camera;
  const double longest = options.seconds > 0.0 ? std::min(options.seconds, kLongestSample) : kLongestSample;
  notice(fmt::format("sampling{}{}",
                     options.seconds > 0.0 ? fmt::format(" for {:g} s", longest) : "; Ctrl-C ends",
                     needs.keys ? "; Enter says that the tip is there, then hold still" : ""));
  MonotonicClock<PhysicsClock> clock;
  MarkedMoments moments(needs.keys);
  SampleProgress progress;
  SampleCounts counts;
  const auto begun = clock.now();
  auto next = begun, looked = begun;
  double judged_s = 0.0;
  while (!stop.load(std::memory_order_relaxed)) {
    next = std::max(next + std::chrono::milliseconds(1), clock.now() - std::chrono::milliseconds(1));
    clock.sleep_until(next);
    const auto now = clock.now();
    taken.seconds = to_seconds(now - begun);
    if (taken.seconds >= longest) break;
    const Duration waited = now - std::exchange(looked, now);
    if (opened->arm) {
      const auto sample = opened->arm->device().read();
      const auto read = clock.now();  // not before: how long it has waited is counted until it was asked for
      if (sample.connected) taken.streams.add(sample, read - sample.waited, waited), counts.add_arm();
    }
    if (opened->tracker) {
      const auto tracked = opened->tracker->device().poll();
      const auto polled = clock.now();
      for (const auto& sample : tracked)
        taken.streams.add(sample, polled - sample.waited, waited), counts.add(sample);
    }
    if (opened->camera)
      if (const auto image = opened->camera->device().poll()) {
        taken.streams.add_image(image->mid_exposure, clock.now() - image->waited, waited);
        if (needs.picture) needs.picture(*image);
      }
    moments.look(clock.now().seconds(), taken.keys_s);
    if (opened->camera && opened->camera->ended()) break;
    if (taken.seconds >= judged_s + 0.1) {
      judged_s = taken.seconds;
      if (auto there = opened->look(); !there) {
        taken.warnings.push_back(
            fmt::format("ended after {:.1f} s: {}", taken.seconds, there.error().message));
        break;
      }
    }
    std::string line = counts.line(taken.seconds);
    if (needs.keys) line += fmt::format("  touches {}", taken.keys_s.size());
    if (needs.progress) line += "  " + needs.progress();
    progress.show(line, taken.seconds);
  }
  if (!recording->recording) return taken;
  *opened = {};  // what their threads still write is in it then
  if (auto whole = recording->recording->finish(); !whole) return tl::unexpected(whole.error());
  return taken;
}

Expected<TakenSamples> from_recording(const SampleArguments& options, const SampleNeeds& needs) {
  if (!options.arm.empty() || !options.tracker.empty() || !options.camera.empty())
    return wrong_use("--recording {}: goes without --arm, --tracker and --camera",
                     excerpt(options.recording, 100));
  record::session::StreamsToRead what;
  what.span = options.span;
  if (needs.camera) what.camera = options.which_camera;
  what.decode = jpeg_decoder();
  what.picture = needs.picture;
  auto read = record::session::read_streams(options.recording, what);
  if (!read) return tl::unexpected(read.error());
  const std::string file = one_line(options.recording);
  const char* part = options.span.all() ? "" : " between --from and --to";
  if (needs.arm && read->arm == 0)
    return refused(
        "{}: holds no readings of an arm (/arm/sample){}; record with the arm open, as calibrate all "
        "--record does",
        file, part);
  if (needs.tracker && read->tracker == 0)
    return refused("{}: holds nothing of a tracker (/tracker/sample){}", file, part);
  if (needs.camera && read->pictures == 0)
    return refused("{}: holds no pictures of the {} camera{}; record with --pictures jpeg", file,
                   options.which_camera, part);
  TakenSamples taken;
  taken.streams = std::move(read->streams);
  taken.seconds = read->seconds;
  taken.source = file;
  if (read->unread > 0)
    taken.warnings.push_back(
        fmt::format("{} could not be read and are left out", counted(read->unread, "message")));
  if (read->images > read->pictures && needs.camera)
    taken.warnings.push_back(
        fmt::format("{} have no picture in the recording", counted(read->images - read->pictures, "image")));
  return taken;
}

}  // namespace

void add_sample_options(CLI::App& command, SampleArguments& options, const SampleNeeds& needs) {
  if (needs.arm) {
    command.add_option("--arm", options.arm, "The arm: " + drivers().arm_forms())->type_name("URI");
    command.add_flag("--arm-at-reset", options.at_reset,
                     "The arm is in its reset position now: set its encoders' zero there if it is lost");
  }
  command.add_option("--tracker", options.tracker, "The tracker: " + drivers().tracker_forms())
      ->type_name("URI");
  command.add_option("--tracker-tool", options.tracker_tools,
                     "What the tracker calls a marker: tip_marker=NAME, camera_marker=NAME, pointer=NAME");
  if (needs.camera) {
    command.add_option("--camera", options.camera, "The camera: " + drivers().camera_forms())
        ->type_name("URI");
    command.add_option("--which-camera", options.which_camera, "Of a recording: which of its cameras")
        ->check(one_of({"left", "right"}))
        ->capture_default_str();
    add_camera_options(command, options.camera_options);
  }
  command
      .add_option("--recording", options.recording,
                  "In place of devices: the raw streams of this recording (MCAP)")
      ->type_name("FILE");
  command
      .add_option("--from", options.span.from_s, "Of the recording: from so many seconds after its beginning")
      ->check(at_least_zero())
      ->type_name("S");
  command
      .add_option("--to", options.span.to_s, "Of the recording: until so many seconds after its beginning")
      ->check(above_zero())
      ->type_name("S");
  command.add_option("--seconds", options.seconds, "Of devices: stop after this many seconds; 0 = at Ctrl-C")
      ->check(at_least_zero())
      ->default_val(0.0);
  add_record_options(command, options.record);
  command.add_option("--rig", options.rig, "A rig file: tips, lens and nominal arm are read there")
      ->type_name("FILE");
  command.add_option("--out", options.out, "Folder for the tables")->required()->type_name("DIR");
  command.add_option("--json", options.json, "Write counts and warnings here; - = standard output")
      ->type_name("FILE");
}

void add_still_options(CLI::App& command, session::HoldSettings& settings) {
  const auto scaled = [&command](const char* name, double& target, double per_unit, const char* help) {
    command
        .add_option_function<double>(
            name, [&target, per_unit](const double& value) { target = value * per_unit; }, help)
        ->check(above_zero())
        ->default_str(fmt::format("{:g}", target / per_unit));
  };
  scaled("--still-mm", settings.still.place, 1e-3,
         "Held still: the marker's places scatter about their mean by at most this (rms)");
  scaled("--still-deg", settings.still.turn, 1.0 / kDegreesPerRadian, "... and its turns by this");
  scaled("--still-s", settings.still.window_s, 1.0, "... for so long");
}

Expected<TakenSamples> take_samples(const SampleArguments& options, const SampleNeeds& needs) {
  if (!options.recording.empty() && !options.record.file.empty())
    return wrong_use("--record {}: goes with devices, not with --recording",
                     excerpt(options.record.file, 100));
  if (options.recording.empty() && !options.span.all())
    return wrong_use("--from and --to go with --recording FILE");
  const auto rig = rig_of_samples(options);
  if (!rig) return tl::unexpected(rig.error());
  if (options.recording.empty())
    for (const auto& [needed, text, name] : {std::tuple(needs.arm, &options.arm, "--arm"),
                                             {needs.tracker, &options.tracker, "--tracker"},
                                             {needs.camera, &options.camera, "--camera"}})
      if (needed && text->empty()) return wrong_use("{} is required, or --recording FILE", name);
  auto taken =
      options.recording.empty() ? from_devices(options, needs, *rig) : from_recording(options, needs);
  if (!taken) return taken;
  if (taken->streams.restarts() > 0)
    taken->warnings.push_back(fmt::format(
        "a device's clock was set anew, or its samples came late for seconds, {}; times of some seconds "
        "around that may be off",
        taken->streams.restarts() == 1 ? "once" : fmt::format("{} times", taken->streams.restarts())));
  if (needs.arm && taken->streams.arm().empty()) return refused("{}: the arm said nothing", options.arm);
  if (taken->streams.other_arms() > 0)
    taken->warnings.push_back(fmt::format("{} of an arm that has not three joints are left out",
                                          counted(taken->streams.other_arms(), "reading")));
  return taken;
}

Expected<rig::Rig> rig_of_samples(const SampleArguments& options) {
  if (!options.rig.empty()) return rig::read_rig(options.rig);
  rig::Rig rig;
  if (!options.recording.empty())
    rig.nominal_arm = record::session::recorded_arm(options.recording).value_or(rig.nominal_arm);
  return rig;
}

Expected<device::MarkerId> sampled_marker(const std::string& name) {
  const auto marker = device::marker_named(name);
  if (!marker)
    return wrong_use(
        "marker '{}': tip_marker, camera_marker or pointer is expected (--tracker-tool says what the "
        "tracker calls it)",
        excerpt(name));
  return *marker;
}

Expected<std::vector<device::TrackedPose>> sampled_poses(const TakenSamples& taken, device::MarkerId marker,
                                                         const std::string& reference) {
  auto poses = taken.streams.marker_poses(marker);
  if (session::seen_poses(poses).empty())
    return refused("{}: {} was never seen{}", taken.source, device::name_of_marker(marker),
                   poses.empty()
                       ? "; the tracker said nothing of it (--tracker-tool says what it is called)"
                       : fmt::format(" in {}; turn it towards the tracker", counted(poses.size(), "frame")));
  if (reference.empty()) return poses;
  const auto body = sampled_marker(reference);
  if (!body) return tl::unexpected(body.error());
  if (*body == marker) return wrong_use("--reference {}: is the marker itself", reference);
  auto relative = session::in_reference(poses, taken.streams.marker_poses(*body));
  if (session::seen_poses(relative).empty())
    return refused("{}: {} and its reference {} were never seen together", taken.source,
                   device::name_of_marker(marker), reference);
  return relative;
}

Expected<void> write_samples(const SampleArguments& options, const std::string& kind,
                             const TakenSamples& taken, const std::vector<SampleTable>& tables,
                             const Json& counts, const std::string& next_command) {
  if (auto made = make_folder(options.out); !made) return made;
  Json json = counts;
  json["kind"] = kind;
  json["source"] = taken.source;
  json["seconds"] = taken.seconds;
  json["files"] = Json::array();
  json["warnings"] = taken.warnings;
  for (const auto& table : tables) {
    const auto path = std::filesystem::path(options.out) / table.file;
    if (auto done = write_file(path, table.content); !done) return done;
    json["files"].push_back({{"file", path.string()}, {"rows", table.rows}});
    if (options.json != "-") print_line(fmt::format("{:>9}    {}", table.rows, path.string()));
  }
  for (const auto& warning : taken.warnings) notice("warning: " + warning);
  if (!options.json.empty())
    if (auto done = write_json(options.json, json); !done) return done;
  if (options.json != "-" && !next_command.empty()) print_line("next         " + next_command);
  return {};
}

}  // namespace palpate::tools::commands
