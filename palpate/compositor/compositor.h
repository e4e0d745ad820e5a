// The augmented picture: the camera's image with its lens undone, and virtual things standing in it.
//
// Real surfaces and the real arm are known as shapes (phantoms): they hide what is behind them, and carry the
// shadows of virtual things. The picture is CameraModel's pinhole picture: a World point p appears at
// project_undistorted(X_camera_world p), pixel centres at whole numbers, row 0 on top. Deterministic to the
// bit on one version of Mesa. Throws where no OpenGL is to be had. Thread: constructed, used and destroyed on
// one thread; it may share that thread with other users of OpenGL. A view from elsewhere (for a report) is
// the same picture with another image, camera and pose.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "palpate/devices/devices.h"
#include "palpate/draw/arm_shape.h"
#include "palpate/draw/room_light.h"
#include "palpate/model/camera.h"
#include "palpate/scene/application.h"

namespace palpate {

// What is known of the real things in view.
struct RealScene {
  std::vector<SceneSurface> surfaces;         // table, wall, ...
  std::optional<draw::ArmConfiguration> arm;  // at the moment of the image
  std::vector<Vector3> marker_leds;           // m, marker frame: the stylus carries its plate
  double arm_base_below = 0.12;               // m, ArmBase origin above what the arm stands on
};

struct CompositorSettings {
  draw::RoomLight light;
  int samples = 4;  // per pixel of virtual things: 1 (rough edges) or 4
  bool shadows = true;
};

class Compositor {
 public:
  explicit Compositor(const CompositorSettings& settings = {});
  ~Compositor();

  // `camera` is the calibrated one: lens undone by its distortion, drawn with its focal lengths and centre.
  // The image must have the camera's size (std::invalid_argument otherwise). rgb_out: packed RGB, row 0 on
  // top.
  void draw(const CameraImage& image, const CameraModel& camera,
            const Pose<World, CameraOptical>& X_world_camera, std::span<const DrawItem> items,
            const RealScene& real, std::vector<std::uint8_t>& rgb_out);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace palpate
