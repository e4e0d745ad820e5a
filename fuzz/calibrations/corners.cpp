// Tables of chessboard corners into the camera's calibration, and one view's board pose.
#include "fuzz/check.h"
#include "palpate/vision/camera.h"

namespace palpate::fuzz {

Refusals corners(std::string_view file) {
  Refusals refusals;
  const auto shape = vision::board_shape("9x6", 0.025);
  auto read = vision::parse_board_corners(file, "corners.csv", *shape);
  if (!answered(read, refusals)) return refusals;
  cut(read->views, 6);
  const int width = read->width > 0 ? read->width : 640, height = read->height > 0 ? read->height : 480;
  const auto lens = vision::calibrate_camera(read->views, width, height, {.reject_outlier_views = true});
  device::CameraModel camera;
  if (answered(lens, refusals)) {
    camera = lens->value.model;
    for (const double number : {camera.fx, camera.fy, camera.cx, camera.cy, lens->value.rms_px})
      hold_finite(number, "a lens is finite");
    for (const double number : camera.distortion) hold_finite(number, "a distortion is finite");
  } else {
    camera.width = 640, camera.height = 480, camera.fx = camera.fy = 535.0, camera.cx = 320.0,
    camera.cy = 240.0;
  }
  const auto pose = vision::board_pose(camera, read->views.front());
  if (answered(pose, refusals)) hold_finite(pose->value.X_camera_board, "a board's pose is rigid");
  return refusals;
}

}  // namespace palpate::fuzz
