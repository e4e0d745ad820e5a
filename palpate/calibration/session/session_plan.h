// How much of everything a calibration session asks for, and what its steps have in common: where a result
// comes from, and how a refusal is passed on. SI units. Pure.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "palpate/calibration/session/guided_poses.h"
#include "palpate/calibration/session/procedures.h"
#include "palpate/core/expected.h"
#include "palpate/rig/rig.h"

namespace palpate::calibration::session {

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
  device::LensKind lens = device::LensKind::brown;
  double look_s = 5.0;               // head as in use: landmarks from pictures
  std::function<std::string()> now;  // ISO 8601, for the provenance of what is done then; none: not told
};

// Of a calibration's result: `data` is what it was computed from.
rig::Provenance provenance(const CalibrationPlan& plan, const std::string& data, const std::string& method,
                           double rms_mm);
std::string bytes_of(const std::vector<TrackedPose>& poses);
std::string bytes_of(const std::vector<TouchedPoint>& touches);

template <typename T>
tl::unexpected<Error> failed(const Expected<T>& step) {
  return tl::unexpected(step.error());
}

}  // namespace palpate::calibration::session
