// The figures of a demo, as summary.json has them: measured against the world's truth, nothing judged.
#pragma once

#include <vector>

#include "palpate/calibration/session/calibration_session.h"
#include "palpate/core/json.h"
#include "palpate/evaluation/arm_comparison.h"
#include "palpate/evaluation/overlay_of_play.h"
#include "palpate/scene/application_registry.h"
#include "palpate/sim/lockstep/lockstep_play.h"
#include "tools/demo/demo.h"

namespace palpate::tools::demo {

// Of a play with two cameras.
struct StereoOverlay {
  evaluation::OverlayOfPlay right;
  evaluation::DisparityErrors disparity;
};

struct DemoOutcome {
  const DemoOptions& options;
  const sim::Truth& truth;
  const rig::Rig& rig;
  const calibration::session::CalibrationRecordings& recordings;
  const std::vector<evaluation::MethodErrors>& methods;        // joint last
  const std::vector<evaluation::MethodErrors>& with_true_tip;  // the same with a perfect tip
  const sim::lockstep::LockstepResult& play;
  const evaluation::OverlayOfPlay& overlay;  // of the only camera, or of the left one
  const std::optional<StereoOverlay>& stereo;
  std::size_t check_points;
  const scene::SceneDescription& scene;
  const scene::PlayRecord& record;
};

// Everything but "pictures", "realtime" and "made". Refused where the application's part has a key that is the system's.
Expected<Json> demo_summary(const DemoOutcome& outcome);

// The game of a person who took the mouse in the real-time run, in the application's words; empty where nobody did.
std::vector<scene::ClosingLine> own_game(const Json& summary, const scene::PlayRecord& record);

// The plain lines a demo ends with. `of_the_play`: the application's, of the play in lock-step. A person's own game, in
// summary.json's "realtime/own_game", comes before it. `verdicts`: the report's of that name; what falls short is told.
std::vector<std::string> closing_lines(const Json& summary,
                                       const std::vector<scene::ClosingLine>& of_the_play,
                                       const Json& verdicts, const std::filesystem::path& out);

}  // namespace palpate::tools::demo
