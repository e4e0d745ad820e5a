// Calibrating a whole rig through its devices, in the order in which each step can use the ones before.
//
// Rest readings, pointer tip, surfaces, landmarks, stylus tip, arm, delay arm-tracker, lens, hand-eye with
// delay camera-tracker, landmarks again from pictures; the same for a second camera where there is one, with
// the landmarks as the first one has left them. Every step goes through Laboratory (devices and a
// person who is asked for gestures), writes its part of the rig, and is skipped where the rig has it already:
// a session that broke off goes on where it stopped. No truth in here. One thread. Errors: the step's
// refusal, which says what to do.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "palpate/acquisition/procedures.h"
#include "palpate/calibration/arm.h"
#include "palpate/calibration/board.h"
#include "palpate/calibration/pose_refinement.h"
#include "palpate/model/rig.h"
#include "palpate/system/guided_poses.h"

namespace palpate {

struct CalibrationPlan {
  int corner_rounds = 2;  // how often each surface's four corners are touched
  int pivot_poses = 400;
  double pivot_s = 20.0;
  int arm_points = 70, arm_test_points = 70;  // the latter always of the person's own choice
  bool guided = true;                         // the former are shown to the person where they help most
  ReachablePoses reach;                       // of this arm, where this tracker sees its stylus
  std::uint64_t guidance_seed = 1;            // draws the candidates
  double moving_s = 8.0;
  double board_s = 12.0;  // head around the calibration board: lens and hand-eye
  int board_every = 2;    // every so many images are searched for the board
  int lens_views = 30;    // of these, used for the lens
  double look_s = 5.0;    // head as in use: landmarks from pictures
  std::string date;       // ISO 8601, for the provenance
};

// Of one camera.
struct CameraRecordings {
  std::vector<BoardView> lens_views;
  std::vector<TimedPose<World, CameraMarker>> hand;
  std::vector<TimedPose<Board, CameraOptical>> eye;
  double landmark_rms_px_before = 0.0, landmark_rms_px = 0.0;
};

// What was recorded, for raw data and figures; parts that were skipped are empty.
struct CalibrationRecordings {
  std::vector<TrackedPose> pointer_pivot, tip_pivot;
  std::vector<Touch> corners, landmark_touches;
  std::vector<ArmObservation> arm_train, arm_test;
  std::vector<TrackedPose> arm_poses;  // the same as recorded
  // Predicted error of the arm (m rms over its range) after each pose, for the poses of the calibration and
  // for as many of the held-out ones, which the person chose.
  std::vector<double> arm_predicted, arm_predicted_random;
  CameraRecordings camera, right_camera;
};

// Finds landmarks in an image: predicted from the camera's pose, as the compositor's detector does it. The
// sightings state their covariance.
using FindLandmarks =
    std::function<std::vector<Sighting>(const CameraImage&, const CameraCalibration&,
                                        const Pose<World, CameraOptical>&, const std::vector<Landmark>&)>;

struct SessionHooks {
  std::function<void(std::size_t step, std::size_t steps, const std::string& name)> progress;
  std::function<Expected<void>(const Rig&)> save;              // after each step, so that nothing is lost
  FindLandmarks find_landmarks;                                // empty: the last step is left out
  std::function<void(const GuidanceState&, int of)> guidance;  // after each guided pose of the arm
};

Expected<CalibrationRecordings> calibrate_rig(Laboratory lab, Rig& rig, const CalibrationPlan& plan,
                                              const SessionHooks& hooks);

// The recording as calibrate_arm wants it; the tip's covariance as the tracker believes it for a tip at
// `tip`.
std::vector<ArmObservation> arm_observations(const std::vector<TrackedPose>& poses, const Vector3& tip);

// The arm's result as the rig keeps it.
ArmCalibration rig_arm(const Estimate<ArmSolution>& estimate);

}  // namespace palpate
