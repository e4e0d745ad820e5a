// The detector of landmarks as the calibration session wants it.
#pragma once

#include "palpate/calibration/session/camera_session.h"

namespace palpate::calibration::session {

FindLandmarks landmark_finder();

}  // namespace palpate::calibration::session
