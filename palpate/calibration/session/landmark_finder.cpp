#include "palpate/calibration/session/landmark_finder.h"

#include "palpate/vision/sightings.h"

namespace palpate::calibration::session {

FindLandmarks landmark_finder() { return vision::find_sightings; }

}  // namespace palpate::calibration::session
