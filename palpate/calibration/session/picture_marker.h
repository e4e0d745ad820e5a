// Where the camera's marker was when a picture was taken: by the stamps of both devices, so that what is drawn into a
// picture stays in its place while the head turns.
//
// World frame, m. One thread, that of the session.
#pragma once

#include <optional>
#include <span>

#include "palpate/calibration/session/guided_person.h"
#include "palpate/device/devices.h"
#include "palpate/device/marker_history.h"
#include "palpate/time/clock_model.h"

namespace palpate::calibration::session {

class PictureMarker {
 public:
  // What the tracker has told until `now_s`, host time. In each tick.
  void watch(double now_s, std::span<const device::TrackerSample> tracked);
  // Not seen: the tracker did not see the marker then. Pictures in their order, each at the host time `now_s` at which
  // it was looked at; `camera_after_tracker_s` as in rig::DelayCalibration.
  SeenMarker at(const device::CameraImage& image, double now_s, double camera_after_tracker_s);

 private:
  ClockEstimator<TrackerClock, GraphicsClock> tracker_clock_;
  ClockEstimator<CameraClock, GraphicsClock> camera_clock_;
  device::MarkerHistory history_;
  std::optional<double> watched_s_;
};

}  // namespace palpate::calibration::session
