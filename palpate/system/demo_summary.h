// The figures of a demo, as summary.json has them: measured against the world's truth, nothing judged.
#pragma once

#include <vector>

#include "palpate/core/json.h"
#include "palpate/system/arm_comparison.h"
#include "palpate/system/calibration_session.h"
#include "palpate/system/demo.h"
#include "palpate/system/overlay_of_play.h"

namespace palpate {

// Of a play with two cameras.
struct StereoOverlay {
  OverlayOfPlay right;
  DisparityErrors disparity;
};

struct DemoOutcome {
  const DemoOptions& options;
  const sim::Truth& truth;
  const Rig& rig;
  const CalibrationRecordings& recordings;
  const std::vector<MethodErrors>& methods;        // joint last
  const std::vector<MethodErrors>& with_true_tip;  // the same with a perfect tip
  const LockstepResult& play;
  const OverlayOfPlay& overlay;  // of the only camera, or of the left one
  const std::optional<StereoOverlay>& stereo;
  std::size_t check_points;
};

// Everything but "pictures" and "realtime".
Json demo_summary(const DemoOutcome& outcome);

// The five plain lines a demo ends with.
std::vector<std::string> closing_lines(const Json& summary, const std::filesystem::path& out);

}  // namespace palpate
