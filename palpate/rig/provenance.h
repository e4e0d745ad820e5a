// Where a calibration came from. A value.
#pragma once

#include <string>

namespace palpate::rig {

struct Provenance {
  std::string date;       // ISO 8601, UTC
  std::string data_hash;  // content_hash of the samples
  std::string method;     // "joint", "algebraic", ...
  double rms_mm = 0.0;    // of its residuals, per component (px for the camera's lens)
};

}  // namespace palpate::rig
