// Places all over the part of a body's surface that a tip can reach, evenly spread.
//
// Many points are drawn at random, as many per area everywhere, and one after the other is kept unless it lies too near
// to one that has been kept (Poisson disc). Always the same for the same surface. Metres, the surface's frame. Pure;
// it allocates.
#pragma once

#include <vector>

#include "palpate/physics/deformable/surface_load.h"
#include "palpate/scene/mesh.h"

namespace palpate::physics::organ {

// `spacing`: about that to the nearest one, m. Reachable is what lies `support` above the lowest point or higher and
// does not face the table.
std::vector<deformable::SurfaceSite> surface_sites(const scene::TriangleMesh& surface, double spacing,
                                                   const Vector3& up, double support);

}  // namespace palpate::physics::organ
