// Calibrating a whole rig through its devices, in the order in which each step can use the ones before.
//
// Rest readings, pointer tip, surfaces, landmarks, stylus tip, arm, delay arm-tracker, lens, hand-eye with
// delay camera-tracker, landmarks again from pictures; the same for a second camera where there is one, with
// the landmarks as the first one has left them. Every step goes through AcquisitionContext (devices and a
// person who is asked for gestures), writes its part of the rig, and is skipped where the rig has it already:
// a session that broke off goes on where it stopped. Who reviews the steps may have one done again, also one
// that failed. No truth in here. One thread. Errors: the step's refusal, which says what to do, or
// ErrorCode::stopped.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "palpate/calibration/arm.h"
#include "palpate/calibration/session/arm_observations.h"
#include "palpate/calibration/session/camera_session.h"
#include "palpate/calibration/session/guided_poses.h"
#include "palpate/calibration/session/procedures.h"
#include "palpate/calibration/session/session_plan.h"
#include "palpate/rig/rig.h"

namespace palpate::calibration::session {

// What was recorded, for raw data and figures; parts that were skipped are empty.
struct CalibrationRecordings {
  std::vector<TrackedPose> pointer_pivot, tip_pivot;
  std::vector<TouchedPoint> corners, landmark_touches;
  std::vector<device::ArmObservation> arm_train, arm_test;
  std::vector<TrackedPose> arm_poses;  // the same as recorded
  // Predicted error of the arm (m rms over its range) after each pose, for the poses of the calibration and
  // for as many of the held-out ones, which the person chose.
  std::vector<double> arm_predicted, arm_predicted_random;
  CameraRecordings camera, right_camera;
};

// How a step ended, for whoever reviews it.
struct StepOutcome {
  std::string step;
  bool done = false;
  std::string words;   // its result with its figures, or why there is none
  bool first = false;  // nothing before it could be undone
};

enum class Review : std::uint8_t {
  go_on,   // of a step that failed: the session ends with its refusal
  repeat,  // this step
  undo,    // this step and the one before are to be done again
  stop,    // the session ends; what is done is kept
};

struct SessionHooks {
  std::function<void(std::size_t step, std::size_t steps, const std::string& name)> progress;
  // For each step whose result the rig has from before, after `progress`.
  std::function<void(const std::string& name, const std::string& words)> kept;
  std::function<Expected<void>(const rig::Rig&)> save;  // after each step, so that nothing is lost
  // After each step that has found something: what has been recorded so far.
  std::function<void(const CalibrationRecordings&)> recorded;
  std::function<Review(const StepOutcome&)> review;            // after each step; empty: go on
  FindLandmarks find_landmarks;                                // empty: the last step is left out
  std::function<void(const GuidanceState&, int of)> guidance;  // after each guided pose of the arm
};

Expected<CalibrationRecordings> calibrate_rig(AcquisitionContext context, rig::Rig& rig,
                                              const CalibrationPlan& plan, const SessionHooks& hooks);

}  // namespace palpate::calibration::session
