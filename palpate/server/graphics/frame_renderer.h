// What the graphics server needs to see and to draw: landmark detection with pose refinement, and the
// compositor.
//
// Made from the rig and the scene; used on the thread that made it (it owns an OpenGL context). Throws where
// no OpenGL is to be had.
#pragma once

#include <array>
#include <functional>
#include <memory>

#include "palpate/render/compositor.h"
#include "palpate/render/outside_view.h"
#include "palpate/rig/rig.h"
#include "palpate/scene/application.h"
#include "palpate/server/graphics/graphics_server.h"
#include "palpate/server/graphics/real_objects.h"
#include "palpate/vision/charuco.h"
#include "palpate/vision/landmark_detector.h"
#include "palpate/vision/overlay_estimate.h"

namespace palpate::server::graphics {

// Whether the arm's links hide virtual things in the picture: a PHANToM's do; those of a chain have no known
// shape, and a mouse's arm is not there.
bool has_body(const rig::ArmCalibration& arm);

class FrameRenderer : public FramePipeline {
 public:
  FrameRenderer(const FrameRenderer&) = delete;
  FrameRenderer& operator=(const FrameRenderer&) = delete;
  // Throws std::invalid_argument where a mesh of the rig's objects cannot be read (RealObjects::read tells it
  // beforehand).
  FrameRenderer(const rig::Rig& rig, const scene::SceneDescription& scene,
                std::unique_ptr<scene::SceneView> scene_view,
                render::Quality quality = render::Quality::medium);

  // Draws so from now on. What a level needs is made when it is first asked for, which takes some frames' time.
  void set_quality(render::Quality quality);
  // Draws a picture that nobody sees, so that what a driver compiles and buffers at first use is there before the first
  // image. Nothing of it is left in later pictures.
  void rehearse();
  // Called at the end of each stage of refining and drawing (Compositor::watch_stages).
  void watch_stages(std::function<void(const char* stage)> watcher);
  // The hand at the stylus, as the camera sees it: it hides virtual things.
  void set_hand(device::HoldingHand hand) { hand_ = hand; }
  // Score and rally stand in the picture's corner, unless somebody else shows them.
  void set_captions(bool shown) { captions_shown_ = shown; }

  bool sees() const override { return true; }
  void refine(EyeSide side, const device::CameraImage& image, const Matrix6& covariance,
              EyePose& pose) override;
  Expected<void> find(const device::CameraImage& image, const std::optional<Pose<World, CameraOptical>>& near,
                      FrameRecord& record) override;
  // As the application carries it on.
  scene::SceneState predict(const scene::SceneState& state, Duration ahead) override {
    return scene_view_->predict(state, ahead);
  }
  void draw(const device::CameraImage& image, const device::CameraImage* right, FrameRecord& record) override;

  std::vector<std::string> captions(const scene::SceneState& state) const {
    return scene_view_->captions(state);
  }
  // Draws in the next of the view's ways from now on; its name. None where there is one way alone.
  std::optional<std::string> next_look();
  // In the way that suits a person at a window.
  void draw_for_window();
  bool has_looks() const { return scene_view_->looks().size() > 1; }
  // A drawn frame as seen from the side (outside_view.h), of the size of the camera's picture; drawn once for
  // each frame, when it is first asked for. Valid until the next frame is asked for.
  const render::OutsidePicture& outside(const FrameRecord& record);
  // Who sees it so; when they walk, it is seen from there in the next frame.
  render::Onlooker& onlooker() { return onlooker_; }

 private:
  // What belongs to one camera.
  struct EyeParts {
    rig::Rig rig;  // as if that camera were the only one
    vision::OverlayKnowledge known;
  };
  render::RealScene real_things(const FrameRecord& record) const;
  std::vector<scene::DrawItem> virtual_things(const FrameRecord& record) const;
  // Nobody knows where the camera is, nor where its picture's virtual things would stand.
  bool lost() const;

  void done(const char* stage) const {
    if (watcher_) watcher_(stage);
  }

  EyeParts left_;
  const rig::Rig& rig_ = left_.rig;
  std::optional<EyeParts> right_;
  scene::SceneDescription scene_;
  std::unique_ptr<scene::SceneView> scene_view_;
  RealObjects objects_;
  std::array<std::unique_ptr<render::Compositor>, 3> compositors_;  // of each quality, once it was drawn with
  render::Compositor* compositor_ = nullptr;                        // the one in use
  std::function<void(const char*)> watcher_;
  render::Onlooker onlooker_;
  render::PlayersCamera players_camera_;
  std::optional<render::Furniture> furniture_;  // of a table in a room; what a desk stands on nobody knows
  render::OutsidePicture outside_;
  bool captions_shown_ = true;
  device::HoldingHand hand_ = device::HoldingHand::none;
  std::size_t look_ = 0;                 // of the view's ways to draw
  scene::TriangleMesh outline_;          // of a desk's table and wall, which nobody would see otherwise
  int lost_ = 0;                         // images in a row without the board
  std::optional<std::string> stranger_;  // the dictionary of another board that lies there
};

}  // namespace palpate::server::graphics
