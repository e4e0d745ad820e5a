#include "palpate/device/lens_fold.h"

namespace palpate::device {

bool folds_inside(const CameraModel& camera) {
  for (const double u : {0.0, camera.width - 1.0})
    for (const double v : {0.0, camera.height - 1.0})
      if (!angle_from_axis(camera, {u, v})) return true;
  return false;
}

}  // namespace palpate::device
