// One camera of a rig is calibrated through the laboratory: lens and hand-eye from a movement of the head
// around the board, then both again, with the landmarks, from pictures of the scene.
//
// Every step writes into the rig's camera and hand-eye and into the recordings; the devices and the person
// are the AcquisitionContext's. One thread. Errors: the step's refusal, which says what to do.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "palpate/calibration/session/landmark_frames.h"
#include "palpate/calibration/session/procedures.h"
#include "palpate/calibration/session/session_plan.h"
#include "palpate/rig/rig.h"
#include "palpate/vision/board.h"
#include "palpate/vision/landmark_refinement.h"
#include "palpate/vision/pose_refinement.h"

namespace palpate::calibration::session {

// Of one camera.
struct CameraRecordings {
  std::vector<vision::BoardView> lens_views;
  std::vector<TimedPose<World, CameraMarker>> hand;
  std::vector<TimedPose<Board, CameraOptical>> eye;
  double landmark_rms_px_before = 0.0, landmark_rms_px = 0.0;
};

// The parts of a rig that one camera has for itself.
struct RigEye {
  std::optional<rig::CameraCalibration>& camera;
  std::optional<rig::HandEyeCalibration>& hand_eye;
};

// Of the camera's stamps after the tracker's.
struct CameraDelay {
  double seconds = 0.0, std_s = 0.0;
};

class CameraSession {
 public:
  // Plan, rig and recordings must outlive this object.
  CameraSession(const AcquisitionContext& context, const CalibrationPlan& plan, RigEye eye,
                CameraRecordings& recorded)
      : context_(context), plan_(plan), eye_(eye), recorded_(recorded) {}

  Expected<CameraDelay> lens_and_hand_eye();

  // Improves lens and hand-eye. `touch`: how well the landmarks' places were touched, where that is asked.
  Expected<Estimate<vision::LandmarkRefinement>> landmarks_from_pictures(
      const std::vector<rig::Landmark>& landmarks, double camera_after_tracker_s,
      const FindLandmarks& find_landmarks, const std::optional<rig::TouchNoise>& touch);

 private:
  AcquisitionContext context_;
  const CalibrationPlan& plan_;
  RigEye eye_;
  CameraRecordings& recorded_;
};

}  // namespace palpate::calibration::session
