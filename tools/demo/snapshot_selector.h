// Pictures for the report: moments of a game that a person wants to see, chosen while it is played.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/core/json.h"
#include "palpate/device/camera_model.h"
#include "palpate/render/outside_view.h"
#include "palpate/scene/application.h"
#include "palpate/server/graphics/frame_record.h"

namespace palpate::tools::demo {

// The ball's centre is inside the drawn picture and the bat does not hide it. World frame; pure.
bool ball_in_sight(const server::graphics::FrameRecord& frame, const device::CameraModel& lens,
                   const scene::SceneDescription& scene);

// What the frame shows of the game, in words: where the ball is on its way, or the tip. `hit`: the bat has
// just met the ball, or the tip the surface; `seen`: ball or tip are in sight. Pure.
std::string what_is_seen(const server::graphics::FrameRecord& frame, const scene::SceneDescription& scene,
                         bool hit, bool seen);

// Moments evenly over the play, and one after each of the first hits, or touches: each the next frame in
// which the ball, or the tip, is in sight. One thread.
class SnapshotSelector {
 public:
  SnapshotSelector(std::filesystem::path folder, double seconds, const device::CameraModel& lens,
                   const scene::SceneDescription& scene);

  // Besides, one picture from the side (outside.png): of the first hit, or else of the first moment.
  void look_from_outside(
      std::function<const render::OutsidePicture&(const server::graphics::FrameRecord&)> outside) {
    outside_ = std::move(outside);
  }
  // Frames in order; writes the picture when this is a moment. Refuses when it cannot be written.
  Expected<void> look(const server::graphics::FrameRecord& frame);
  const Json& captions() const { return captions_; }  // by file name

 private:
  bool in_sight(const server::graphics::FrameRecord& frame) const;
  std::string moment(const server::graphics::FrameRecord& frame) const;
  Expected<void> write_outside(const server::graphics::FrameRecord& frame, bool hit);

  std::filesystem::path folder_;
  device::CameraModel lens_;
  scene::SceneDescription scene_;
  double every_, begun_ = 0.0, next_ = 0.0, hit_until_ = 0.0;
  bool started_ = false;
  std::function<const render::OutsidePicture&(const server::graphics::FrameRecord&)> outside_;
  int count_ = 0, hit_pictures_ = 0;
  std::int32_t hits_ = 0;
  Json captions_ = Json::object();
};

}  // namespace palpate::tools::demo
