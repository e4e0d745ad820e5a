// How well a predicted picture was predicted: what it showed, beside what was there when its light left the display.
//
// Later, when that moment is past, the physics server is asked for the states of that moment and of the image's, the
// tracker for the head's marker. So the errors need no truth from outside and are those of a real arm, too; an error that
// arm or tracker make at both times alike does not show. World, m, rad. One thread, the frame loop's.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "palpate/device/marker_history.h"
#include "palpate/scene/application.h"
#include "palpate/server/graphics/frame_record.h"
#include "palpate/time/clock_model.h"
#include "palpate/transport/state_link.h"

namespace palpate::server::graphics {

// How far something was from where it was when the light left, m: as the picture showed it, as the newest state had it that
// was known, and as a registered picture would have shown it.
struct PlaceErrors {
  double shown = 0.0, newest = 0.0, registered = 0.0;
};

// Of one picture.
struct PredictionError {
  std::uint64_t frame = 0;
  double ahead_s = 0.0;   // by so much the state was carried on
  double moment_s = 0.0;  // the light left so much after the moment that the picture was made for
  std::optional<PlaceErrors> tip;
  // Of each body that can be seen; empty where it was struck or set elsewhere meanwhile, which nobody can foresee.
  std::vector<std::optional<PlaceErrors>> bodies;
  std::optional<double> head_m, head_rad;  // of the marker on the head
  std::optional<double>
      shape_m;  // of the surface that deforms, which is shown as the newest known, at its worst vertex
};

// What a picture showed.
struct PredictedPicture {
  const FrameRecord* frame = nullptr;
  const scene::SceneState* newest = nullptr;         // before it was carried on
  std::shared_ptr<const scene::Shape> newest_shape;  // the same
  std::optional<Pose<World, CameraMarker>> marker;   // where the head's marker was expected
  Instant<GraphicsClock> light, marker_light,
      image_time;  // marker_light: that moment by the tracker's stamps
};

class PredictionCheck {
 public:
  static constexpr Duration kAskedAfter = std::chrono::milliseconds(20);
  static constexpr std::size_t kWaiting = 32;  // pictures; older ones are given up
  static constexpr std::uint64_t kShapeEvery = 4;

  explicit PredictionCheck(transport::StateLink& link) : link_(link) {}

  void shown(const PredictedPicture& picture);
  // Asks what is due and takes what link.poll() has brought.
  void service(Instant<GraphicsClock> now, const ClockModel<GraphicsClock, PhysicsClock>& sync,
               Duration tracker_after_arm, const device::MarkerHistory& camera_marker,
               const scene::SceneDescription& scene);
  // Those that have become known, oldest first, since the last call.
  std::vector<PredictionError> take() { return std::exchange(known_, {}); }

 private:
  struct Waiting {
    PredictionError error;
    scene::SceneState shown, newest;
    std::shared_ptr<const scene::Shape> shape;
    std::optional<Pose<World, CameraMarker>> marker;
    Instant<GraphicsClock> light, marker_light, image_time;
    bool asked = false;
    std::optional<scene::SceneState> at_light, at_image;
    std::shared_ptr<const scene::Shape> shape_at_light;
  };
  void ask(Waiting& picture, const ClockModel<GraphicsClock, PhysicsClock>& sync, Duration tracker_after_arm);
  void take_answers();
  void judge(Waiting& picture, const device::MarkerHistory& camera_marker,
             const scene::SceneDescription& scene) const;

  transport::StateLink& link_;
  std::deque<Waiting> waiting_;
  std::vector<PredictionError> known_;
};

}  // namespace palpate::server::graphics
