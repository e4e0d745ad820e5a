// The tables that calibrations read, made of the raw streams of arm and tracker, whether these come from devices or out of a
// recording.
//
// Frames and times as of DeviceStreams. Pure. Refused: streams that do not hold what the table is made of, with the likely reason.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/session/holds.h"
#include "palpate/core/expected.h"
#include "palpate/device/arm_model.h"

namespace palpate::calibration::session {

// Poses in which the marker was seen.
std::vector<TrackedPose> seen_poses(const std::vector<TrackedPose>& poses);

// The stylus' still poses with the arm's readings, a mean pose for each hold.
std::vector<TrackedPose> still_arm_poses(const device::DeviceStreams& streams,
                                         const HoldSettings& settings = {});

// For each of seen poses the number of the rest of a pivot that it belongs to, 1, 2, ...; 0: in none (pivot_rests.h).
Expected<std::vector<int>> pivot_segments(const std::vector<TrackedPose>& poses);

// `name`: pivot, pointer_pivot, hand: the seen poses of tip marker, pointer and camera marker, with the arm's readings for pivot where
// there are some. arm: the still poses where there are at least ten, else every pose; `tip` and `model` as of arm_csv().
Expected<std::string> table_from_streams(const device::DeviceStreams& streams, const std::string& name,
                                         const Vector3& tip = Vector3::Zero(),
                                         const device::ArmModel& model = {});

}  // namespace palpate::calibration::session
