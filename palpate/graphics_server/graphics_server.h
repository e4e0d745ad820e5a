// The graphics server: camera and tracker in, augmented picture out, one frame per image, never waiting for
// anyone.
//
// At the start of a frame it asks the physics server for the state at the time the image was taken, goes on
// with the camera's pose, and at the end draws with the reply if it has come, else with the previous state.
// Time is passed in, so the same code runs in lock-step on a virtual clock and in a frame loop on the
// machine's. One thread.
//
// Time lines. Tracker and camera stamps are brought to the graphics host's clock by one clock estimator each;
// the constant latencies left in them are the rig's calibrated delays: an image is brought onto the tracker's
// time line (camera_after_tracker), then through the clock synchronisation to the physics host and onto the
// arm's time line (tracker_after_arm).
#pragma once

#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "palpate/devices/devices.h"
#include "palpate/graphics_server/frame_record.h"
#include "palpate/graphics_server/marker_history.h"
#include "palpate/model/rig.h"
#include "palpate/network/state_link.h"
#include "palpate/scene/application.h"
#include "palpate/time/clock_model.h"

namespace palpate {

// Improves record.X_world_camera by what is seen in the image; `covariance` is that of the tracker's pose
// (rotation in World axes, then translation). Given by the composition, as is the painter, which draws the
// frame into record.rgb: so the server runs without pixels in tests.
using PoseRefiner =
    std::function<void(const CameraImage& image, const Matrix6& covariance, FrameRecord& record)>;
using FramePainter = std::function<void(const CameraImage& image, FrameRecord& record)>;

// Whoever wants to know of each marker that is seen, in the order of arrival; called by service().
using MarkerTap = std::function<void(MarkerId marker, const MarkerPose& pose)>;

class GraphicsServer {
 public:
  // Throws std::invalid_argument where the rig lacks camera or hand-eye.
  GraphicsServer(Rig rig, StateLink& link, TrackerDevice& tracker, CameraDevice& camera, PoseRefiner refiner,
                 FramePainter painter);

  // Takes tracker samples and whatever came over the network, keeps the clocks synchronised. Call every
  // millisecond or so, and at least once per frame.
  void service(Instant<GraphicsClock> now);

  // Takes up the newest image if there is one; true when a frame has begun.
  bool begin_frame(Instant<GraphicsClock> now);

  // Finishes the frame that was begun: reply or previous state, picture. The record stays valid until the
  // next call.
  const FrameRecord& finish_frame(Instant<GraphicsClock> now);

  void tap_markers(MarkerTap tap) { tap_ = std::move(tap); }

  bool frame_begun() const { return image_.has_value(); }
  const ClockSync<GraphicsClock, PhysicsClock>& sync() const { return sync_; }
  // Round trips of requests, s, in the order of arrival, since the last call.
  std::vector<double> take_round_trips();

 private:
  void estimate_pose(FrameRecord& record);

  Rig rig_;
  StateLink& link_;
  TrackerDevice& tracker_;
  CameraDevice& camera_;
  PoseRefiner refiner_;
  FramePainter painter_;
  MarkerTap tap_;
  ClockEstimator<TrackerClock, GraphicsClock> tracker_clock_;
  ClockEstimator<CameraClock, GraphicsClock> camera_clock_;
  ClockSync<GraphicsClock, PhysicsClock> sync_;
  std::optional<Instant<GraphicsClock>> last_sync_sent_, last_look_;
  MarkerHistory camera_marker_;
  std::optional<CameraImage> arrived_image_, image_;  // waiting, and being worked on
  std::optional<StateAnswer> last_answer_;
  std::vector<double> round_trips_;
  Pose<World, CameraOptical> last_pose_;
  FrameRecord record_;
  std::uint64_t frames_ = 0;
};

}  // namespace palpate
