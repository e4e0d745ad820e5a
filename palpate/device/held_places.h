// Where the stylus is wanted for the check of the arm's forces: Gesture::hold, number 0, 1, ...
#pragma once

#include <array>

#include "palpate/math/pose.h"

namespace palpate::device {

// The ways there from the middle of the arm's reach; World, m.
inline const std::array<Vector3, 5> kHeldPlaces{Vector3{0.0, 0.0, 0.0}, Vector3{-0.09, 0.06, 0.0},
                                                Vector3{0.09, 0.06, 0.0}, Vector3{-0.09, -0.06, 0.0},
                                                Vector3{0.09, -0.06, 0.0}};

}  // namespace palpate::device
