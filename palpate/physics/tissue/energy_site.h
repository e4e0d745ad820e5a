// What pressing costs at one place of a body's surface: the energy stored as a function of the tip's depth.
// Body's frame, SI. Value.
#pragma once

#include <vector>

#include "palpate/math/so3.h"

namespace palpate::physics::tissue {

struct EnergySite {
  Vector3 place = Vector3::Zero();    // on the surface
  Vector3 normal = Vector3::UnitZ();  // outwards, unit
  // Rising depths > 0 that the tip's sphere reaches below the undeformed surface, and the energy stored there.
  std::vector<double> depth_m, energy_j;
};

}  // namespace palpate::physics::tissue
