// How far a played game's pictures were from the truth: each frame's overlay errors and all of them together.
#pragma once

#include <optional>
#include <vector>

#include "palpate/core/json.h"
#include "palpate/core/statistics.h"
#include "palpate/evaluation/overlay.h"
#include "palpate/evaluation/played_frame.h"
#include "palpate/rig/rig.h"
#include "palpate/sim/truth.h"

namespace palpate::evaluation {

// A surveyed point of table or wall: where it truly is, and where the calibrated surface says it is. World,
// m.
struct CheckPoint {
  Vector3 truth, estimate;
};

// A grid over each surface that the rig knows.
std::vector<CheckPoint> check_points(const sim::Truth& truth, const rig::Rig& rig);

struct FrameErrors {
  std::optional<double> world_px, world_px_tracker, tip_px;  // rms over the points seen; empty where none was
  std::optional<double> expected_world_px;                   // the system's own estimate of world_px
};

struct OverlayOfPlay {
  std::vector<FrameErrors> frames;         // one per frame
  ErrorSummary world, world_tracker, tip;  // px, every point of every frame
  ErrorSummary frame_world,
      expected_world;  // px, frame by frame: true rms, and the system's own estimate of it
};

OverlayOfPlay overlay_of_play(const std::vector<PlayedFrame>& frames, const device::CameraModel& lens,
                              const std::vector<CheckPoint>& points);

// The same for the right camera, over the frames that it has a part in.
OverlayOfPlay overlay_of_right_eye(const std::vector<PlayedFrame>& frames, const device::CameraModel& lens,
                                   const std::vector<CheckPoint>& points);

// The figures of a summary: rms and p95 in px of world and tip, by the tracker alone, and the system's own
// estimate beside the truth (frame by frame, rms of both over the same frames). What was never seen is not
// there.
Json overlay_figures(const OverlayOfPlay& overlay);

// By how much, in px, the difference between a virtual point's places in the two eyes' pictures is not that
// of a real one at its place: over the points and, where it is shown, the first virtual body.
struct DisparityErrors {
  ErrorSummary world, body;
};
DisparityErrors disparity_of_play(const std::vector<PlayedFrame>& frames, const rig::Rig& rig,
                                  const std::vector<CheckPoint>& points);

}  // namespace palpate::evaluation
