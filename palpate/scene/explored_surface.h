// The surface that an application lets a hand explore, for whoever leads the tip over it without seeing the law of its
// force: a mouse. Values.
#pragma once

#include "palpate/scene/mesh.h"

namespace palpate::scene {

struct ExploredSurface {
  TriangleMesh mesh;          // World, m; at rest
  double tip_radius = 0.0;    // m, of the sphere that touches it
  double press = 0.005;       // m: so deep a button presses
  double deepest = 0.008;     // m: deeper nobody needs to go
  double full_force_n = 0.0;  // where a bar that shows the force ends; 0: at the most that the arm can give
};

}  // namespace palpate::scene
