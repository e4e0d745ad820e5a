#include "tools/commands/calibrate_live.h"

#include <map>
#include <memory>

#include "palpate/calibration/session/calibration_session.h"
#include "palpate/calibration/session/landmark_finder.h"
#include "palpate/calibration/session/sample_csv.h"
#include "palpate/core/stop_signal.h"
#include "palpate/core/units.h"
#include "palpate/record/session/recorded_tables.h"
#include "palpate/time/clock.h"
#include "tools/commands/command.h"
#include "tools/commands/drivers.h"
#include "tools/commands/terminal_panel.h"

namespace palpate::tools::commands {
namespace {

namespace session = calibration::session;

struct Opened {
  std::unique_ptr<device::OpenedArm> arm;
  std::unique_ptr<device::OpenedTracker> tracker;
  std::unique_ptr<device::OpenedCamera> camera;

  // Of the first that is gone.
  Expected<void> look() {
    if (auto there = arm->look(); !there) return there;
    if (auto there = tracker->look(); !there) return there;
    return camera->look();
  }
};

Expected<Opened> open(const LiveDevices& names, const rig::Rig& rig, const device::DriverRegistry& known) {
  for (const auto& [option, text] :
       {std::pair("--arm", names.arm), {"--tracker", names.tracker}, {"--camera", names.camera}})
    if (text.empty())
      return wrong_use(
          "{} is missing: a session needs arm, tracker and camera (palpate doctor shows what there is)",
          option);
  Opened opened;
  auto arm = known.open(
      device::ArmRequest{.uri = names.arm, .nominal = rig.nominal_arm, .at_reset_position = names.at_reset});
  if (!arm) return tl::unexpected(arm.error());
  opened.arm = std::move(*arm);
  auto tracker = known.open(device::TrackerRequest{names.tracker, names.tools});
  if (!tracker) return tl::unexpected(tracker.error());
  opened.tracker = std::move(*tracker);
  device::CameraRequest request{names.camera, {}};
  if (drivers().names_camera(names.camera, device::Offer::real)) {
    auto asked = camera_request(drivers(), names.camera, names.camera_options);
    if (!asked) return tl::unexpected(asked.error());
    request = *asked;
  }
  auto camera = known.open(request);
  if (!camera) return tl::unexpected(camera.error());
  opened.camera = std::move(*camera);
  return opened;
}

// The session's recording, where it is asked for, and the drivers that write into it.
struct Recorded {
  std::unique_ptr<record::session::SessionRecording> recording;
  device::DriverRegistry drivers;
  std::map<std::string, std::string> tables;  // as they were attached last
};

Expected<Recorded> begin_recording(const RecordOptions& options, const rig::Rig& rig) {
  auto pictures = picture_recording(options);
  if (!pictures) return tl::unexpected(pictures.error());
  if (options.file.empty()) return Recorded{nullptr, drivers(), {}};
  auto begun =
      record::session::SessionRecording::begin(options.file, {.recorder = "calibrate all", .on_error = {}});
  if (!begun) return tl::unexpected(begun.error());
  if (auto done = (*begun)->attach("rig-before.toml", "application/toml", rig::rig_text(rig)); !done)
    return tl::unexpected(done.error());
  Recorded recorded{std::move(*begun), {}, {}};
  recorded.drivers = record::session::recorded_drivers(drivers(), *recorded.recording, *pictures);
  return recorded;
}

// What the calibrations worked on, as their tables: the newest of each name counts.
void keep_tables(Recorded& recorded, const session::CalibrationRecordings& recordings, const rig::Rig& rig) {
  const Vector3 tip = rig.tip_pivot ? rig.tip_pivot->tip_in_marker : Vector3(Vector3::Zero());
  for (const auto& [name, text] : session::session_tables(recordings, tip)) {
    std::string& last = recorded.tables[name];
    if (last == text) continue;
    last = text;
    if (auto done = recorded.recording->attach(record::session::table_attachment(name), "text/csv", text);
        !done)
      notice(done.error().message);
  }
}

// A person whose devices are looked at meanwhile: one that goes ends the session, in words.
class PersonAtDevices : public session::GuidedPerson {
 public:
  PersonAtDevices(session::Panel& panel, Opened& devices) : GuidedPerson(panel), devices_(devices) {}

  Expected<bool> ready() override {
    if (!there_) return tl::unexpected(there_.error());
    return GuidedPerson::ready();
  }
  void watch(double now_s, const device::ArmSample& arm,
             std::span<const device::TrackerSample> tracked) override {
    constexpr double kLook = 0.1;  // s
    if (there_ && now_s >= looked_s_ + kLook) {
      there_ = devices_.look();
      looked_s_ = now_s;
    }
    GuidedPerson::watch(now_s, arm, tracked);
  }

 private:
  Opened& devices_;
  Expected<void> there_{};
  double looked_s_ = 0.0;
};

}  // namespace

Expected<void> calibrate_live(const LiveDevices& devices, const std::string& rig_file, rig::Rig rig,
                              session::CalibrationPlan plan) {
  auto recording = begin_recording(devices.record, rig);
  if (!recording) return tl::unexpected(recording.error());
  auto opened = open(devices, rig, recording->drivers);
  if (!opened) return tl::unexpected(opened.error());
  const auto& stop = stop_requested();
  auto panel = TerminalPanel::open(devices.instructions, stop);
  if (!panel) return tl::unexpected(panel.error());
  PersonAtDevices person(**panel, *opened);
  MonotonicClock<PhysicsClock> clock;
  const auto right = opened->camera->right();
  if (!right) return tl::unexpected(right.error());
  session::AcquisitionContext context{clock,
                                      opened->arm->device(),
                                      opened->tracker->device(),
                                      &opened->camera->device(),
                                      person,
                                      *right,
                                      opened->arm->facts().simulated,
                                      &stop};
  session::SessionHooks hooks;
  hooks.progress = [&panel](std::size_t step, std::size_t steps, const std::string& name) {
    (*panel)->begin_step(step, steps, name);
  };
  hooks.guidance = [&panel](const session::GuidanceState& state, int of) {
    (*panel)->tell(fmt::format("pose {} of {}, {}", state.poses, of, session::guidance_text(state)));
  };
  hooks.save = [&rig_file](const rig::Rig& so_far) { return rig::write_rig(rig_file, so_far); };
  if (recording->recording)
    hooks.recorded = [&recording, &rig](const session::CalibrationRecordings& recordings) {
      keep_tables(*recording, recordings, rig);
    };
  hooks.review = [&panel](const session::StepOutcome& outcome) { return (*panel)->review(outcome); };
  hooks.find_landmarks = session::landmark_finder();
  const auto done = session::calibrate_rig(context, rig, plan, hooks);
  panel->reset();
  if (recording->recording) {
    if (auto kept = recording->recording->attach("rig.toml", "application/toml", rig::rig_text(rig)); !kept)
      notice(kept.error().message);
    if (const Json figures = recording->recording->close(); figures.contains("error"))
      return refused("{}: the recording is not whole: {}", devices.record.file,
                     figures["error"].get<std::string>());
  }
  if (!done) return tl::unexpected(done.error());
  fmt::print("{}: complete; held-out error of the arm {:.3f} mm\n", one_line(rig_file),
             mm_from_metres(rig.arm->held_out_mean));
  return {};
}

}  // namespace palpate::tools::commands
