// What a frame passes through between a camera's image and the finished picture: find or refine, predict,
// draw.
//
// The graphics server calls it, in this order, and keeps time, clocks and network to itself. FrameRenderer is
// the one that looks at pixels; NullFramePipeline does without them, for tests and for plays that nobody looks
// at. World, SI. One thread, the graphics server's; it must outlive the server.
#pragma once

#include <cstdint>
#include <optional>

#include "palpate/core/expected.h"
#include "palpate/device/devices.h"
#include "palpate/scene/scene_state.h"
#include "palpate/server/graphics/frame_record.h"

namespace palpate::server::graphics {

// Of two cameras; the only one there is counts as the left one.
enum class EyeSide : std::uint8_t { left, right };

class FramePipeline {
 public:
  virtual ~FramePipeline() = default;
  // False: refine() and find() know nothing, and nobody need miss what they would have seen.
  virtual bool sees() const = 0;
  // Improves pose.X_world_camera by what is seen in that eye's image; `covariance` is that of the pose as it
  // stands there, hand-eye not counted (rotation in World axes, then translation). It sets pose_source to
  // refined where it could.
  virtual void refine(EyeSide side, const device::CameraImage& image, const Matrix6& covariance,
                      EyePose& pose) = 0;
  // For a rig with a board, which has no tracker: finds the camera's pose from the image alone, sets
  // record.X_world_camera and its covariance, or says why it cannot. `near`: where the camera was a moment
  // ago, if that is known.
  virtual Expected<void> find(const device::CameraImage& image,
                              const std::optional<Pose<World, CameraOptical>>& near, FrameRecord& record) = 0;
  // The state carried on by a moment, for a picture of the near future.
  virtual scene::SceneState predict(const scene::SceneState& state, Duration ahead) = 0;
  // Draws the frame into record.rgb. `right`: null where there is one camera, or where the right one is silent
  // (record.two_eyes tells which).
  virtual void draw(const device::CameraImage& image, const device::CameraImage* right,
                    FrameRecord& record) = 0;
};

// Poses stay as the tracker gives them, bodies move on steadily, nothing is drawn.
class NullFramePipeline : public FramePipeline {
 public:
  bool sees() const override { return false; }
  void refine(EyeSide, const device::CameraImage&, const Matrix6&, EyePose&) override {}
  Expected<void> find(const device::CameraImage&, const std::optional<Pose<World, CameraOptical>>&,
                      FrameRecord&) override {
    return refused("nobody looks at the images");
  }
  scene::SceneState predict(const scene::SceneState& state, Duration ahead) override {
    return scene::extrapolate(state, ahead);
  }
  void draw(const device::CameraImage&, const device::CameraImage*, FrameRecord&) override {}
};

}  // namespace palpate::server::graphics
