// From CameraModel to OpenGL: the projection whose pictures lie pixel for pixel on the undistorted camera
// image.
//
// CameraOptical axes (x right, y down, z forward). Pixel centres are whole numbers in CameraModel and halves
// in OpenGL's window, hence the +0.5; row 0 of the picture is OpenGL's row 0, so triangles that are
// counter-clockwise to the eye are clockwise in the window. Pure functions.
#pragma once

#include "palpate/device/camera_model.h"
#include "palpate/math/pose.h"
#include "palpate/render/gl_objects.h"

namespace palpate::render {

// Clip coordinates from CameraOptical, for a picture of camera.width x camera.height (the lens is ignored).
Matrix4f projection_matrix(const device::CameraModel& camera, double near_m, double far_m);

template <typename A, typename B>
Matrix4f matrix4(const Pose<A, B>& X) {
  Matrix4f m = Matrix4f::Identity();
  m.topLeftCorner<3, 3>() = X.matrix().template cast<float>();
  m.topRightCorner<3, 1>() = X.translation.template cast<float>();
  return m;
}

}  // namespace palpate::render
