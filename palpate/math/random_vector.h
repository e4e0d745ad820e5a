// Random 3-vectors: a component each, drawn in the order x, y, z.
#pragma once

#include "palpate/core/random.h"
#include "palpate/math/so3.h"

namespace palpate::inline math {

inline Vector3 normal3(Random& random, double sd = 1.0) {
  return {random.normal(sd), random.normal(sd), random.normal(sd)};
}

// Each component between -size and size.
inline Vector3 uniform3(Random& random, double size) {
  return {random.uniform(-size, size), random.uniform(-size, size), random.uniform(-size, size)};
}

}  // namespace palpate::inline math
