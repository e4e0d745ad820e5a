#include "tools/commands/calibrate_live.h"

#include <memory>

#include "palpate/calibration/session/calibration_session.h"
#include "palpate/calibration/session/landmark_finder.h"
#include "palpate/calibration/session/recorder.h"
#include "palpate/core/units.h"
#include "tools/commands/command.h"
#include "tools/commands/device_recording.h"

namespace palpate::tools::commands {

namespace {

namespace session = calibration::session;

// `steps` becomes the number of the session's own; `more` come after them.
session::SessionHooks hooks_for(session::SessionPanel& panel, const std::string& rig_file, std::size_t& steps,
                                std::size_t more) {
  session::SessionHooks hooks;
  hooks.progress = [&panel, &steps, more](std::size_t step, std::size_t of, const std::string& name) {
    steps = of;
    panel.begin_step(step, of + more, name);
  };
  hooks.kept = [&panel](const std::string& name, const std::string& words) { panel.keep_step(name, words); };
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
  const bool possible = key_can_be_held(forces);
  const auto held = possible ? holds_for_forces(*live, steps) : Expected<bool>(false);
  forces.instructions = live->instructions();
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
  auto recorded = DeviceRecording::begin(devices.record, "calibrate all", rig);
  if (!recorded) return tl::unexpected(recorded.error());
  auto opened = LiveSession::open(devices, rig, recorded->drivers(), exchange);
  if (!opened) return tl::unexpected(opened.error());
  LiveSession& live = **opened;
  std::size_t steps = 0;
  const bool forces_wanted = forces_due(rig, live.arm_facts());
  if (forces_wanted && !key_can_be_held(forces))
    notice(
        "standard input is no terminal whose space bar could be held: the last step, the check of the arm's "
        "forces, is left out "
        "(--key-button N takes a button of the stylus, --yes-held counts the key as held throughout)");
  session::SessionHooks hooks = hooks_for(live.panel(), rig_file, steps, forces_wanted ? 1 : 0);
  hooks.recorded = [&recorded, &rig](const session::CalibrationRecordings& recordings) {
    recorded->keep_tables(recordings, rig);
  };
  const auto done = session::calibrate_rig(live.context(), rig, plan, hooks);
  if (!done) live.end();
  if (auto whole = recorded->finish(rig); !whole) return whole;
  if (!done) return tl::unexpected(done.error());
  if (!forces_wanted)
    live.end();
  else if (auto checked = check_forces(std::move(*opened), steps, devices, rig_file, forces); !checked)
    return checked;
  fmt::print("{}: complete; held-out error of the arm {:.3f} mm; each morning: palpate verify --quick\n",
             one_line(rig_file), mm_from_metres(rig.arm->held_out_mean));
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
