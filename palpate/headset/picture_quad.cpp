#include "palpate/headset/picture_quad.h"

namespace palpate::headset {
namespace {

// Half a turn about x: between axes with y and z of opposite sense. Exact, which an exponential would not be.
const Quaternion kHalfTurnAboutX(0.0, 1.0, 0.0, 0.0);

}  // namespace

PictureQuad picture_quad(const device::CameraModel& camera, double depth) {
  // (0, 0) is the centre of the first pixel: the picture's middle is at (width - 1) / 2.
  const double u = 0.5 * (camera.width - 1), v = 0.5 * (camera.height - 1);
  const Vector3 middle(depth * (u - camera.cx) / camera.fx, depth * (v - camera.cy) / camera.fy, depth);
  return {{kHalfTurnAboutX, middle}, depth * camera.width / camera.fx, depth * camera.height / camera.fy};
}

Pose<View, CameraOptical> camera_between_the_eyes() { return {kHalfTurnAboutX, Vector3::Zero()}; }

}  // namespace palpate::headset
