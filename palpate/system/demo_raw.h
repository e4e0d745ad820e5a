// The raw files of a demo: every calibration's samples and each frame's estimates, so that anybody can
// recompute what the summary claims (tests/recompute.py does). Columns carry their units; twelve significant
// digits.
#pragma once

#include <filesystem>
#include <vector>

#include "palpate/core/json.h"
#include "palpate/system/arm_comparison.h"
#include "palpate/system/calibration_session.h"
#include "palpate/system/lockstep_play.h"
#include "palpate/system/overlay_of_play.h"

namespace palpate {

Expected<void> write_calibration_raw(const std::filesystem::path& raw,
                                     const CalibrationRecordings& recordings, const Rig& rig,
                                     const sim::Truth& truth, const std::vector<Vector3>& poses,
                                     const std::vector<MethodErrors>& methods);

// Poses, truth and lens of one eye: frames.csv, truth_frames.csv, lens.csv; of the right one frames_right.csv
// and so on. `errors`: one per frame that eye has a part in (overlay_of_play.h).
Expected<void> write_eye_raw(const std::filesystem::path& raw, EyeSide side, const LockstepResult& play,
                             const SceneDescription& scene, const std::vector<FrameErrors>& errors,
                             const CameraModel& estimated_lens, const CameraModel& true_lens);

// The rest of the play.
Expected<void> write_play_raw(const std::filesystem::path& raw, const LockstepResult& play,
                              const SceneDescription& scene, const std::vector<CheckPoint>& points);

// Result of `calibrate arm` with these keys: gains, offsets_deg, lengths_mm, tip_mm, base.
Json arm_result_json(const ArmSolution& arm);

const char* answer_name(AnswerKind kind);
const char* pose_source_name(PoseSource source);

}  // namespace palpate
