#include "tools/commands/calibrate_live.h"

#include <map>
#include <memory>

#include "palpate/calibration/session/calibration_session.h"
#include "palpate/calibration/session/landmark_finder.h"
#include "palpate/calibration/session/recorder.h"
#include "palpate/calibration/session/sample_csv.h"
#include "palpate/core/units.h"
#include "palpate/record/session/recorded_tables.h"
#include "tools/commands/command.h"
#include "tools/commands/drivers.h"

namespace palpate::tools::commands {

namespace {

namespace session = calibration::session;

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

// `steps` becomes the number of the session's own; `more` come after them.
session::SessionHooks hooks_for(session::SessionPanel& panel, const std::string& rig_file, std::size_t& steps,
                                std::size_t more) {
  session::SessionHooks hooks;
  hooks.progress = [&panel, &steps, more](std::size_t step, std::size_t of, const std::string& name) {
    steps = of;
    panel.begin_step(step, of + more, name);
  };
  hooks.guidance = [&panel](const session::GuidanceState& state, int of) { panel.guided(state, of); };
  hooks.save = [&panel, &rig_file](const rig::Rig& so_far) {
    panel.show_rig(so_far);
    return rig::write_rig(rig_file, so_far);
  };
  hooks.review = [&panel](const session::StepOutcome& outcome) { return panel.review(outcome); };
  hooks.find_landmarks = session::landmark_finder();
  return hooks;
}

// Whether the person holds the stylus for the check of its forces; false: not today.
Expected<bool> holds_for_forces(LiveSession& live, std::size_t steps) {
  live.panel().begin_step(steps, steps + 1, "forces of the arm");
  const session::AcquisitionContext context = live.context();
  if (auto asked = context.person.ask({device::Gesture::hold, "", 0}); !asked)
    return tl::unexpected(asked.error());
  const auto there = session::Recorder(context).run_until_ready();
  if (!there && there.error().code == ErrorCode::no_more) return false;
  if (!there) return tl::unexpected(there.error());
  return true;
}

// The last step. The devices are closed when it comes to the pushing, for the check has a loop of its own.
Expected<void> check_forces(std::unique_ptr<LiveSession> live, std::size_t steps, const LiveDevices& devices,
                            const std::string& rig_file, ForceArguments forces) {
  const auto held = holds_for_forces(*live, steps);
  live->end();
  live.reset();
  if (!held) return tl::unexpected(held.error());
  forces.arm = devices.arm;
  forces.rig = rig_file;
  forces.at_reset = devices.at_reset;
  if (*held) return check_forces_of(forces);
  notice(
      fmt::format("forces stay off until `palpate calibrate forces --arm {} --rig {}` has seen where they go",
                  one_line(devices.arm), one_line(rig_file)));
  return {};
}

// `exchange`: to the window; null where there is none.
Expected<void> calibrate_with(const LiveDevices& devices, const std::string& rig_file, rig::Rig rig,
                              const session::CalibrationPlan& plan, const ForceArguments& forces,
                              desktop::SessionExchange* exchange) {
  auto recording = begin_recording(devices.record, rig);
  if (!recording) return tl::unexpected(recording.error());
  auto opened = LiveSession::open(devices, rig, recording->drivers, exchange);
  if (!opened) return tl::unexpected(opened.error());
  LiveSession& live = **opened;
  std::size_t steps = 0;
  const bool forces_wanted = forces_due(rig, live.arm_facts());
  session::SessionHooks hooks = hooks_for(live.panel(), rig_file, steps, forces_wanted ? 1 : 0);
  if (recording->recording)
    hooks.recorded = [&recording, &rig](const session::CalibrationRecordings& recordings) {
      keep_tables(*recording, recordings, rig);
    };
  const auto done = session::calibrate_rig(live.context(), rig, plan, hooks);
  if (!done) live.end();
  if (recording->recording) {
    if (auto kept = recording->recording->attach("rig.toml", "application/toml", rig::rig_text(rig)); !kept)
      notice(kept.error().message);
    if (auto whole = recording->recording->finish(); !whole) return tl::unexpected(whole.error());
  }
  if (!done) return tl::unexpected(done.error());
  fmt::print("{}: complete; held-out error of the arm {:.3f} mm\n", one_line(rig_file),
             mm_from_metres(rig.arm->held_out_mean));
  if (forces_wanted) return check_forces(std::move(*opened), steps, devices, rig_file, forces);
  live.end();
  return {};
}

}  // namespace

Expected<void> calibrate_live(const LiveDevices& devices, const std::string& rig_file, const rig::Rig& rig,
                              const session::CalibrationPlan& plan, const ForceArguments& forces) {
  return run_session(devices, "Palpate calibration", [&](desktop::SessionExchange* exchange) {
    return calibrate_with(devices, rig_file, rig, plan, forces, exchange);
  });
}

}  // namespace palpate::tools::commands
