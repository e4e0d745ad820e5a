#include "tools/commands/calibrate_live.h"

#include "palpate/calibration/session/calibration_session.h"
#include "palpate/calibration/session/landmark_finder.h"
#include "palpate/core/units.h"
#include "tools/commands/command.h"

namespace palpate::tools::commands {

namespace session = calibration::session;

Expected<void> calibrate_live(const LiveDevices& devices, const std::string& rig_file, rig::Rig rig,
                              session::CalibrationPlan plan) {
  auto opened = LiveSession::open(devices, rig);
  if (!opened) return tl::unexpected(opened.error());
  LiveSession& live = **opened;
  TerminalPanel& panel = live.panel();
  session::SessionHooks hooks;
  hooks.progress = [&panel](std::size_t step, std::size_t steps, const std::string& name) {
    panel.begin_step(step, steps, name);
  };
  hooks.guidance = [&panel](const session::GuidanceState& state, int of) {
    panel.tell(fmt::format("pose {} of {}, {}", state.poses, of, session::guidance_text(state)));
  };
  hooks.save = [&rig_file](const rig::Rig& so_far) { return rig::write_rig(rig_file, so_far); };
  hooks.review = [&panel](const session::StepOutcome& outcome) { return panel.review(outcome); };
  hooks.find_landmarks = session::landmark_finder();
  const auto done = session::calibrate_rig(live.context(), rig, plan, hooks);
  live.end();
  if (!done) return tl::unexpected(done.error());
  fmt::print("{}: complete; held-out error of the arm {:.3f} mm\n", one_line(rig_file),
             mm_from_metres(rig.arm->held_out_mean));
  return {};
}

}  // namespace palpate::tools::commands
