// The raw files of a demo: every calibration's samples and each frame's estimates, so that anybody can
// recompute what the summary claims (tests/recompute.py does). Columns carry their units; twelve significant
// digits.
#pragma once

#include <filesystem>
#include <vector>

#include "palpate/calibration/session/calibration_session.h"
#include "palpate/core/json.h"
#include "palpate/evaluation/arm_comparison.h"
#include "palpate/evaluation/overlay_of_play.h"
#include "palpate/scene/application_registry.h"
#include "palpate/sim/lockstep/lockstep_play.h"

namespace palpate::tools::demo {

Expected<void> write_calibration_raw(const std::filesystem::path& raw,
                                     const calibration::session::CalibrationRecordings& recordings,
                                     const rig::Rig& rig, const sim::Truth& truth,
                                     const std::vector<Vector3>& poses,
                                     const std::vector<evaluation::MethodErrors>& methods);

// Poses, truth and lens of one eye: frames.csv, truth_frames.csv, lens.csv; of the right one frames_right.csv
// and so on. `errors`: one per frame that eye has a part in (overlay_of_play.h).
Expected<void> write_eye_raw(const std::filesystem::path& raw, server::graphics::EyeSide side,
                             const sim::lockstep::LockstepResult& play,
                             const std::vector<evaluation::FrameErrors>& errors,
                             const device::CameraModel& estimated_lens, const device::CameraModel& true_lens);

// The rest of the play.
Expected<void> write_play_raw(const std::filesystem::path& raw, const sim::lockstep::LockstepResult& play,
                              const std::vector<evaluation::CheckPoint>& points);

// The application's own tables, after all others. Refused where the record has not as many as were announced, and
// where a file of that name is there.
Expected<void> write_tables(const std::filesystem::path& raw, const scene::ApplicationSpec& application,
                            const scene::PlayRecord& record);

// Result of `calibrate arm` with these keys: gains, offsets_deg, lengths_mm, tip_mm, base.
Json arm_result_json(const calibration::ArmSolution& arm);

}  // namespace palpate::tools::demo
