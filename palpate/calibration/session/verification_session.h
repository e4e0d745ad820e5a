// A calibrated rig is looked at anew: what a person does at the devices so that it can be verified.
//
// Arm at rest, the stylus held in poses of the person's choice, corners and landmarks touched with the pointer,
// the stylus moved freely, the landmarks looked at from a moving head; the calibration board, where that is asked
// for. Everything goes through AcquisitionContext and nothing is changed in the rig. No truth in here. SI, World.
// One thread. Errors: refused, where the rig lacks what is to be verified, and each recording's own.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "palpate/calibration/session/landmark_frames.h"
#include "palpate/calibration/verification.h"

namespace palpate::calibration::session {

struct VerificationPlan {
  int poses = 12;           // of the stylus
  int corners_of_each = 4;  // of table and wall, from the first on
  int landmarks = 4;        // touched, spread over those there are
  double moving_s = 8.0;    // 0: the tracker's delay is not looked at
  double look_s = 5.0;      // of the landmarks
  int every = 6;            // one picture in so many
  double board_s = 4.0;     // of the calibration board; 0: none

  // Before each day's work: half a minute.
  static VerificationPlan quick();
};

// How well the lens alone describes the calibration board's views; not a part of what is tested.
struct BoardFigure {
  int views = 0;
  double rms_px = 0.0;       // sqrt(sum |r|^2 / n) over all corners, each view's pose fitted
  double promised_px = 0.0;  // the lens calibration's
};

struct VerificationRecord {
  RigObservations observed;
  std::optional<BoardFigure> board;
  std::string no_delay;  // why the free motion does not tell the tracker's delay; empty where it does
  double delay_correlation =
      0.0;               // of arm and marker at the delay that was found; 0: none was looked for, or found
  double seconds = 0.0;  // host time that it took
};

struct VerificationHooks {
  std::function<void(std::size_t step, std::size_t steps, const std::string& name)> progress;
  FindLandmarks find_landmarks;
};

Expected<VerificationRecord> observe_rig(AcquisitionContext context, const rig::Rig& rig,
                                         const VerificationPlan& plan, const VerificationHooks& hooks);

}  // namespace palpate::calibration::session
