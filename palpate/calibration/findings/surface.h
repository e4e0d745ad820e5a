// Real rectangles from touched points: what fit_rectangles finds, and what is to be thought of the touches.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/findings/findings.h"
#include "palpate/calibration/surface.h"

namespace palpate::calibration::findings {

struct SurfaceFindings {
  std::vector<Estimate<RectangleFit>> estimates;
  std::vector<Json> json;  // of each surface
  Json all;                // of the only one, or {"surfaces": [...]}
};

// Surfaces that one hand has touched.
Expected<SurfaceFindings> find_surfaces(std::vector<SurfaceTouches> touched,
                                        const RectangleOptions& options = {});

}  // namespace palpate::calibration::findings
