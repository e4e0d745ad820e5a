// How far the pictures of the real-time run were from the truth, judged after the play from two files that
// two processes wrote without knowing of each other: what each picture was drawn with (pose_log.h) and what
// was true when its image was taken (exposure_log.h). World, m; pixels as overlay.h has them.
#pragma once

#include <filesystem>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/device/camera_model.h"
#include "palpate/evaluation/overlay_of_play.h"

namespace palpate::evaluation {

struct OverlayCase {
  device::CameraModel lens, true_lens;  // calibrated, and true
  std::vector<CheckPoint> points;
  double warm_up_s = 0.0;  // pictures of this time from the start do not count, as in lock-step
};

// What the case is for a world of this seed and a rig calibrated in it.
OverlayCase overlay_case(const sim::config::WorldFile& world, std::uint64_t seed, const rig::Rig& rig);

// Figures with the names of the lock-step's (world_px_rms ... own_estimate_over_true, pose_from), and
// tip_px_rms_in_time and tip_px_rms_late (the previous state was drawn because the reply was late), frames,
// late, unjudged (nothing is known of their image). Adds columns
// world_px, world_px_tracker and tip_px to the first file. Refused where a file is not as it should be.
Expected<Json> evaluate_overlay(const std::filesystem::path& poses, const std::filesystem::path& truth,
                                const OverlayCase& against);

}  // namespace palpate::evaluation
