// What the graphics server knew and did for one frame: the row that goes into raw data and figures.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "palpate/geometry/pose.h"
#include "palpate/scene/world_state.h"
#include "palpate/time/instant.h"

namespace palpate {

enum class PoseSource : std::uint8_t { none, tracker, refined };

struct FrameRecord {
  std::uint64_t number = 0;        // of the frames drawn, 1, 2, ...
  std::uint64_t camera_frame = 0;  // the camera's own count
  Instant<CameraClock> stamp;
  Instant<GraphicsClock> image_time;    // mid-exposure, camera delay taken off, on the tracker's time line
  Instant<GraphicsClock> begun, drawn;  // image taken up, picture finished
  Instant<PhysicsClock> asked;          // the moment whose state was asked for
  bool requested = false;               // the request could go out
  bool late = false;                    // its reply was not there in time: the previous state was used
  AnswerKind answer = AnswerKind::too_old;
  Duration extrapolated_by{0};
  bool have_state = false;
  WorldState state;  // the state that was drawn
  PoseSource pose_source = PoseSource::none;
  Pose<World, CameraOptical> X_world_camera;          // used for drawing
  Pose<World, CameraOptical> X_world_camera_tracker;  // from tracker and hand-eye alone
  int landmarks_predicted = 0, landmarks_used = 0;
  double landmark_rms_px = 0.0;
  std::optional<double> stated_overlay_px;  // the overlay error as the pose's own covariance has it, rms
  std::vector<std::uint8_t> rgb;            // the drawn picture; empty where nothing was drawn
  int width = 0, height = 0;
};

}  // namespace palpate
