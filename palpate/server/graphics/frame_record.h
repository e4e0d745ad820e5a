// What the graphics server knew and did for one frame: the row that goes into raw data and figures.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "palpate/device/camera_model.h"
#include "palpate/math/pose.h"
#include "palpate/scene/scene_state.h"
#include "palpate/scene/shape.h"
#include "palpate/server/graphics/conditions.h"
#include "palpate/time/instant.h"

namespace palpate::server::graphics {

// none: the last pose, as nothing was known. tracker: hand-eye and tracker alone. refined: by landmarks, from
// the tracker's pose on. landmarks: by landmarks from the last poses on, while the tracker is blind.
enum class PoseSource : std::uint8_t { none, tracker, refined, landmarks };

// The moment that a picture's virtual things belong to: that of the camera's image (they fit it exactly, and
// are as old as it is), or that at which the picture's light leaves the display.
enum class PictureTime : std::uint8_t { registered, predicted };

// A landmark as it was found: its pixel in the undistorted picture, and whether the pose was refined by it.
struct FoundLandmark {
  device::Pixel place = device::Pixel::Zero();
  bool used = false;
};

// Where a camera was when it took an image, as estimated.
struct EyePose {
  PoseSource pose_source = PoseSource::none;
  Pose<World, CameraOptical> X_world_camera;  // used for drawing
  bool have_tracker = false;
  Pose<World, CameraOptical> X_world_camera_tracker;  // from tracker and hand-eye alone, where there was one
  // Of X_world_camera as estimated: rotation (rad, World axes, left perturbation), then translation (m).
  Matrix6 pose_covariance = Matrix6::Zero();
  int landmarks_predicted = 0, landmarks_used = 0, landmarks_rejected = 0;
  std::vector<FoundLandmark> landmarks_found;  // of the rig's landmarks; empty where a board is looked at
  double landmark_rms_px = 0.0;
  double landmark_misfit = 0.0;  // whitened rms: about 1 where detection is as good as it says
  // The system's own estimate of its overlay error on the calibrated surfaces, px rms (overlay_estimate.h).
  std::optional<double> expected_world_px;
};

// Its own pose is that of the only camera, or of the left one.
struct FrameRecord : EyePose {
  std::uint64_t number = 0;        // of the frames drawn, 1, 2, ...
  std::uint64_t camera_frame = 0;  // the camera's own count
  Instant<CameraClock> stamp;
  Instant<GraphicsClock> image_time;    // mid-exposure, camera delay taken off, on the tracker's time line
  Instant<GraphicsClock> arrived;       // the image, at this host
  Instant<GraphicsClock> begun, drawn;  // image taken up, picture finished
  PictureTime picture_time = PictureTime::registered;
  Instant<GraphicsClock> photon;  // when the picture's light is expected to leave the display
  Instant<PhysicsClock> asked;    // the moment whose state was asked for
  bool requested = false;         // the request could go out
  bool late = false;              // its reply was not there in time: the previous state was used
  AnswerKind answer = AnswerKind::too_old;
  Duration extrapolated_by{0};
  // The physics server plays something else than the pipeline draws: there is no state, and the camera's picture is drawn alone.
  bool other_scene = false;
  bool have_state = false;
  scene::SceneState state;  // the state that was drawn
  // Of the surface that deforms, as it was drawn; null: there is none, or it is not known yet.
  std::shared_ptr<const scene::Shape> shape;
  bool two_eyes = false;              // the picture has two halves, for the left eye and for the right
  std::optional<EyePose> right;       // of the right camera, where its image came with the left one's
  std::vector<Condition> conditions;  // what was wrong when the picture was finished
  std::vector<std::uint8_t> rgb;      // the drawn picture; empty where nothing was drawn
  int width = 0, height = 0;
};

}  // namespace palpate::server::graphics
