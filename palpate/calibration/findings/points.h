// The rigid motion between two lists of points that belong together: what absolute_orientation finds, and what is to be
// thought of single points and of the lists' sizes.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/absolute_orientation.h"
#include "palpate/calibration/findings/findings.h"

namespace palpate::calibration::findings {

struct PointPairs {
  std::vector<Vector3> from, to;
  std::vector<double> weights;      // empty: all weigh the same
  std::vector<std::string> labels;  // of each pair
  bool by_label = false;            // how they were paired
};

struct PointFindings {
  Estimate<RigidTransform> estimate;
  Json json;
};

Expected<PointFindings> find_rigid_motion(PointPairs pairs);

}  // namespace palpate::calibration::findings
