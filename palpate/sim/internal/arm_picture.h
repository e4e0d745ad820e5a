// The real arm in the camera's picture: triangles drawn into a layer of their own, then bent through the
// lens.
//
// It stands before everything else, so the layer is laid over what is there. Thread: the OpenGL context's.
#pragma once

#include <Eigen/Core>

#include "palpate/render/arm_body.h"
#include "palpate/render/gl_objects.h"
#include "palpate/render/room_light.h"
#include "palpate/sim/true_view.h"

namespace palpate::sim {

class ArmPicture {
 public:
  ArmPicture();
  // For pictures by this lens, whose rays lie between low and high.
  void prepare(const device::CameraModel& lens, const Eigen::Vector2d& low, const Eigen::Vector2d& high);
  // Over `picture`. The table of rays is bound to unit 0; `falloff` as in the other shaders.
  void draw(const render::ArmBody& body, const TrueView& view, const device::RoomLight& light, float falloff,
            const render::Target& picture, const render::FullScreen& screen);

 private:
  render::Program arm_, through_lens_;
  render::Target layer_;
  Eigen::Vector2d ray_low_, ray_high_;
  device::CameraModel camera_;  // of the layer: no distortion
};

}  // namespace palpate::sim
