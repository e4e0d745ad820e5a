// `palpate calibrate all` with a person at real devices: opens them, leads the person through the session on this
// terminal, and keeps what each step has found in the rig file.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/session/session_plan.h"
#include "palpate/core/expected.h"
#include "palpate/rig/rig.h"
#include "tools/commands/camera_options.h"
#include "tools/commands/record_options.h"

namespace palpate::tools::commands {

struct LiveDevices {
  std::string arm, tracker, camera;
  std::vector<std::string> tools;  // MARKER=NAME
  CameraOptions camera_options;
  RecordOptions record;
  bool at_reset = false;
  std::string instructions;  // file of what is shown

  bool named() const { return !arm.empty() || !tracker.empty() || !camera.empty(); }
};

// Wrong use: not all three devices, or none of such a name; refused: a device that cannot be had or goes, and the
// session's own. ErrorCode::stopped: the person broke off.
Expected<void> calibrate_live(const LiveDevices& devices, const std::string& rig_file, rig::Rig rig,
                              calibration::session::CalibrationPlan plan);

}  // namespace palpate::tools::commands
