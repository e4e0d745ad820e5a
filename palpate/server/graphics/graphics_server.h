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
//
// Which moment a picture shows. *registered*, the default: camera's pose and state at the moment of its
// image. *predicted*: both at the moment its light is expected to leave the display, the state asked for as
// late as may be and carried on from there, the pose by the tracker's motion from the refined one on. At most
// one image waits, the newest; what it is drawn with is latched at the end of the frame.
#pragma once

#include <array>
#include <deque>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "palpate/device/devices.h"
#include "palpate/device/marker_history.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application.h"
#include "palpate/server/graphics/frame_pace.h"
#include "palpate/server/graphics/frame_pipeline.h"
#include "palpate/server/graphics/frame_record.h"
#include "palpate/server/graphics/prediction_check.h"
#include "palpate/server/graphics/stereo_pair.h"
#include "palpate/server/graphics/watched_clock.h"
#include "palpate/time/clock_model.h"
#include "palpate/transport/state_link.h"

namespace palpate::server::graphics {

struct GraphicsSettings {
  PictureTime picture_time = PictureTime::registered;
  // From the end of drawing until the middle of the picture's light leaves the display.
  Duration scan_out{0};
  // Every image is held back so long, on purpose (experiments with visual delay); up to a second.
  Duration extra_delay{0};
};

// Whoever wants to know of each marker that is seen, in the order of arrival; called by service().
using MarkerTap = std::function<void(device::MarkerId marker, const device::MarkerPose& pose)>;

class GraphicsServer {
 public:
  // Throws std::invalid_argument where the rig lacks camera or hand-eye (a rig with a board needs none: its
  // pose is found in the image), or a setting cannot be. Link, devices and pipeline must outlive the server.
  GraphicsServer(rig::Rig rig, transport::StateLink& link, device::TrackerDevice& tracker,
                 device::CameraDevice& camera, FramePipeline& pipeline,
                 const GraphicsSettings& settings = {});

  // A second camera on the same marker that exposes at the same moments: the rig must have both calibrated,
  // and no board (std::invalid_argument otherwise). `one_clock`: its stamps are by the first one's clock, so
  // that they say exactly which images belong together. It must outlive the server.
  void add_right_camera(device::CameraDevice& right, bool one_clock);

  // Takes tracker samples and whatever came over the network, keeps the clocks synchronised. Call every
  // millisecond or so, and at least once per frame.
  void service(Instant<GraphicsClock> now);

  // Takes up the newest image if there is one; true when a frame has begun.
  bool begin_frame(Instant<GraphicsClock> now);

  // Finishes the frame that was begun: reply or previous state, picture. The record stays valid until the
  // next call.
  const FrameRecord& finish_frame(Instant<GraphicsClock> now);

  void set_marker_tap(MarkerTap tap) { tap_ = std::move(tap); }

  // What the camera's driver has to say (ConditionWatch::set_camera_health).
  void set_camera_health(std::optional<device::HealthReport> health) {
    watch_.set_camera_health(std::move(health));
  }
  // The same for the tracker (ConditionWatch::set_tracker_explanation).
  void set_tracker_explanation(std::function<std::string()> why) {
    watch_.set_tracker_explanation(std::move(why));
  }
  // What is wrong with the devices now (conditions.h), as of the last service(); told to a log where there is one.
  const device::HealthMonitor<GraphicsClock>& health() const { return watch_.health(); }
  const std::vector<Condition>& conditions() const { return health().conditions(); }
  void set_log(Log log) { watch_.set_log(log); }
  // What the pipeline draws, with the own rig's surfaces. While the physics server is described to play something else its states
  // are left out of the frames, which are drawn without; that, and surfaces that it has elsewhere, are among the conditions.
  // Without this whatever comes is drawn.
  void set_drawn(scene::SceneDescription drawn) { drawn_ = std::move(drawn); }
  // Where time goes on by itself: whoever calls service() may be held up before the devices are asked, and how long a sample has
  // waited counts from when it was asked for. Must outlive the server; without it times are those handed over.
  void set_clock(const Clock<GraphicsClock>& clock) { clock_ = &clock; }

  // A display that knows when a picture that is finished at some moment will be seen, and itself corrects what the head
  // moves until then (a headset): that is when its light leaves, and a predicted picture's camera stays where it was at its
  // image, for else that motion would count twice.
  using DisplayTime = std::function<Instant<GraphicsClock>(Instant<GraphicsClock> finished)>;
  void set_display(DisplayTime display_time) { display_time_ = std::move(display_time); }

  // The picture of the latest finished frame is ready: when it is to be handed to the display (frame_pace.h); at once where
  // a display knows its own time, or the next image waits.
  Instant<GraphicsClock> ready(Instant<GraphicsClock> at);
  // An image is there that a frame could begin with.
  bool image_waits(Instant<GraphicsClock> now) const;

  // The picture of the latest finished frame has been handed to the display. How long that took, from finish_frame() on,
  // is how far ahead the next ones reckon, and how well a predicted one was predicted is found out from here on. Where
  // nobody says so, drawing takes no time.
  void shown(Instant<GraphicsClock> at);
  // Of predicted pictures, since the last call (prediction_check.h).
  std::vector<PredictionError> take_prediction_errors() { return predictions_.take(); }

  bool frame_begun() const { return image_.has_value(); }
  // The image of the latest finished frame, until the next one is finished.
  const device::CameraImage& finished_image() const { return finished_image_; }
  const ClockSync<GraphicsClock, PhysicsClock>& sync() const { return sync_; }
  // Images of the left camera that were left out as the right one's was lost.
  std::uint64_t unpaired() const { return pair_.unpaired(); }
  // The state that the frame under way asked for is there, or none can come.
  bool answered() const;
  // Round trips of requests, s, in the order of arrival, since the last call.
  std::vector<double> take_round_trips();

 private:
  // Times: of arrival and of mid-exposure, the camera's latency still in it.
  using Arrived = StereoPair::Images;
  // Drawn poses of the last two images: how the head moves, while the tracker does not say.
  struct Drawn {
    Instant<GraphicsClock> time;
    Pose<World, CameraOptical> X_world_camera;
  };
  void take_image(device::CameraImage image, Instant<GraphicsClock> now, Duration waited);
  void take_right_image(device::CameraImage image, Instant<GraphicsClock> now, Duration waited);
  void arrive(Arrived images);
  void take_states(Instant<GraphicsClock> now);
  void meet(const scene::SceneDescription& played, Instant<GraphicsClock> now);
  void estimate_pose(FrameRecord& record);
  void estimate_left(FrameRecord& record);
  void estimate_right(FrameRecord& record) const;
  void pose_without_tracker(FrameRecord& record);
  void pose_from_image(FrameRecord& record);
  Duration tracker_after_arm() const {
    return rig_.delays ? seconds(rig_.delays->tracker_after_arm_s) : Duration(0);
  }
  Instant<GraphicsClock> light_of(Instant<GraphicsClock> presented) const;
  Instant<GraphicsClock> expected_light(Instant<GraphicsClock> now) const;
  void predict(FrameRecord& record);
  void give_back(Arrived images);  // to the cameras
  void predict_pose(FrameRecord& record);
  void predict_state(FrameRecord& record) const;
  void predict_hand(scene::SceneState& state, Duration ahead) const;
  bool predicts() const { return settings_.picture_time == PictureTime::predicted; }

  rig::Rig rig_;
  transport::StateLink& link_;
  device::TrackerDevice& tracker_;
  device::CameraDevice& camera_;
  device::CameraDevice* right_camera_ = nullptr;
  bool one_clock_ = false;
  FramePipeline& pipeline_;
  GraphicsSettings settings_;
  MarkerTap tap_;
  const Clock<GraphicsClock>* clock_ = nullptr;
  DisplayTime display_time_;  // none: a screen, scan_out after drawing
  WatchedClock<TrackerClock> tracker_clock_;
  WatchedClock<CameraClock> camera_clock_, right_camera_clock_;
  StereoPair pair_;
  ClockSync<GraphicsClock, PhysicsClock> sync_;
  std::optional<Instant<GraphicsClock>> last_sync_sent_, last_look_;
  ConditionWatch watch_;
  device::MarkerHistory camera_marker_;
  std::deque<Arrived> arrived_;   // one, the newest, unless images are held back
  std::optional<Arrived> image_;  // being worked on
  device::CameraImage finished_image_;
  std::optional<scene::StateAnswer> last_answer_;
  std::optional<scene::SceneDescription> drawn_;
  std::uint64_t met_ = 0;     // descriptions
  bool other_scene_ = false;  // than drawn_
  // Of a predicted picture: the state that it starts from, one a little before, and where the head's marker will be.
  scene::SceneState newest_state_;
  std::optional<scene::SceneState> state_before_;
  std::optional<Pose<World, CameraMarker>> marker_ahead_;
  PredictionCheck predictions_{link_};
  std::vector<double> round_trips_;
  std::optional<Drawn> last_, before_last_;
  FramePace pace_;
  std::optional<Instant<GraphicsClock>> ready_;  // the latest finished frame's picture, if it was said
  // From finish_frame() until its picture is ready for the display: of the last pictures, and their median, as one in a while takes
  // many times as long (a shader that is compiled).
  std::array<Duration, 15> drawing_times_ = [] {
    std::array<Duration, 15> times;
    times.fill(Duration::max());
    return times;
  }();
  Duration drawing_{0};
  FrameRecord record_;
  std::uint64_t frames_ = 0;
};

}  // namespace palpate::server::graphics
