// `palpate calibrate all` with a person at real devices: opens them, leads the person through the session on this
// terminal and, where that is asked for, in a window, and keeps what each step has found in the rig file. The last step is the check
// of the arm's forces, where the arm needs one.
#pragma once

#include <string>

#include "palpate/calibration/session/session_plan.h"
#include "palpate/core/expected.h"
#include "palpate/rig/rig.h"
#include "tools/commands/force_check.h"
#include "tools/commands/live_devices.h"

namespace palpate::tools::commands {

// Main thread. Wrong use: not all three devices, or none of such a name; refused: a device that cannot be had or goes, and the
// session's own. ErrorCode::stopped: the person broke off.
Expected<void> calibrate_live(const LiveDevices& devices, const std::string& rig_file, const rig::Rig& rig,
                              const calibration::session::CalibrationPlan& plan,
                              const ForceArguments& forces);

}  // namespace palpate::tools::commands
