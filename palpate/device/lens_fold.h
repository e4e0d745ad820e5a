// Where a lens model is used beyond the places that it was fitted to. Pure function.
#pragma once

#include "palpate/device/camera_model.h"

namespace palpate::device {

// Whether the polynomial of the lens turns back on itself before the image's corners.
bool folds_inside(const CameraModel& camera);

}  // namespace palpate::device
