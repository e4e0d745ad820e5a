// The recording procedures: what to ask the person, what to do with the arm meanwhile, and what to keep.
//
// They return samples, not calibrations, and know nothing of what is true. Frames: markers in World (=
// tracker). SI. Errors: refused, where the devices did not show what a calibration needs (with the likely
// reason and remedy).
#pragma once

#include <functional>
#include <vector>

#include "palpate/calibration/session/fixation.h"
#include "palpate/calibration/session/recorder.h"
#include "palpate/calibration/stream_delay.h"

namespace palpate::calibration::session {

struct PivotRecordingOptions {
  int poses = 400;        // kept, spread evenly over the swing
  double seconds = 20.0;  // of swinging; more where the poses need it
  FixationSettings fixation;
  std::function<void()> holding;  // called when the arm has begun to hold the tip
};
// The stylus is swung about its tip, which a computed arm holds; that of a real one stands in a hollow.
Expected<std::vector<TrackedPose>> record_pivot(AcquisitionContext context,
                                                const PivotRecordingOptions& options);

// The pointer is swung about its tip, which stands in a divot. No arm readings.
Expected<std::vector<TrackedPose>> record_pointer_pivot(AcquisitionContext context, int poses,
                                                        double seconds_long);

// The stylus held still in `points` poses over the reach; one tracker frame each.
struct ArmRecordingOptions {
  int points = 140;
  // Where to put the stylus next, given the poses so far; empty, or none: wherever the person likes.
  std::function<std::optional<device::PoseTarget>(const std::vector<TrackedPose>&)> next;
  std::function<void(const std::vector<TrackedPose>&)> kept;  // called after each pose with all of them
};
Expected<std::vector<TrackedPose>> record_arm(AcquisitionContext context, const ArmRecordingOptions& options);
Expected<std::vector<TrackedPose>> record_arm(AcquisitionContext context, int points);

// The stylus moved freely: arm and tracker streams, for the delay between them and for continuous
// calibration.
struct MovingRecord {
  std::vector<ArmReading> arm;      // 1 kHz
  std::vector<TrackedPose> marker;  // tracker rate, with readings interpolated at the uncorrected host time
};
Expected<MovingRecord> record_moving(AcquisitionContext context, double seconds_long);

// By how much, as a standard deviation, a delay found by this motion is off for the tracker's systematic error
// (delay_of_systematic), s. `places`: of the point whose motion the delay was found by, `lever` m from the marker, which
// the error turns as well, by its size over its reach.
double delay_sd_of_systematic(const MovingRecord& moving, const std::vector<TimedPoint>& places,
                              double lever);

// Mean encoder readings with the arm at rest: what a later start is compared with.
Expected<Vector3> record_rest(AcquisitionContext context);

// Pictures with the camera marker's stream, while the person makes a gesture.
struct ViewRecord {
  std::vector<TimedPose<World, CameraMarker>> hand;  // by the tracker, host time
  std::vector<TrackedPose> tracked;                  // the same with covariance
  std::vector<double> image_times_s;                 // of the images `keep` kept, host time
};
// One image in `every` is shown to `keep`, the first of them included; the others only tell the time.
using KeepImage = std::function<bool(const device::CameraImage&)>;
Expected<ViewRecord> record_views(AcquisitionContext context, device::Gesture gesture, double seconds_long,
                                  int every, const KeepImage& keep);

struct HandEyeRecord {
  std::vector<TimedPose<World, CameraMarker>> hand;  // by the tracker, host time
  std::vector<TimedPose<Board, CameraOptical>> eye;  // by the board, host time
};
// The head moves around the board. `see` finds the camera's pose from one image, or none.
using SeeBoard = std::function<std::optional<Pose<Board, CameraOptical>>(const device::CameraImage&)>;
Expected<HandEyeRecord> record_hand_eye(AcquisitionContext context, double seconds_long, const SeeBoard& see);

struct TouchedPoint {
  std::string what;
  int index = 0;
  Vector3 place = Vector3::Zero();  // World, mean over the frames of the touch
  Matrix3 covariance =
      Matrix3::Zero();  // as the tracker believes, m^2; what the person missed by is not in it
  Pose<World, Pointer> X_world_pointer;  // the pointer then: the tip is at `place`
};
// The pointer's tip (calibrated: `tip` in Pointer) held on each place in turn.
Expected<std::vector<TouchedPoint>> record_touches(AcquisitionContext context,
                                                   const std::vector<device::Request>& places,
                                                   const Vector3& tip);

// Where a tip at `tip` in the marker was in the mean of some frames, and the covariance of that as the tracker believes: its noise
// is averaged, its systematic part is not. At least one frame.
struct MeanTip {
  Vector3 place = Vector3::Zero();
  Matrix3 covariance = Matrix3::Zero();  // m^2
};
MeanTip mean_tip(const std::vector<TrackedPose>& frames, const Vector3& tip);

// Requests for the four corners of a surface.
std::vector<device::Request> corner_requests(const std::string& surface);

}  // namespace palpate::calibration::session
