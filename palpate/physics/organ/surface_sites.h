// Places all over the part of a body's surface that a tip can reach, evenly spread.
//
// Many points are drawn at random, as many per area everywhere, and one after the other is kept unless it lies too near
// to one that has been kept (Poisson disc). Where the surface is hollow, in a notch or a saddle, what a tip feels changes
// within a spacing: there they lie half as far apart. Always the same for the same surface. Metres, the surface's frame.
// Pure; it allocates.
#pragma once

#include <vector>

#include "palpate/physics/deformable/surface_load.h"
#include "palpate/physics/tissue/surface_distance.h"
#include "palpate/scene/mesh.h"

namespace palpate::physics::organ {

// `distance`: from that surface. `spacing`: about that to the nearest one, m. Reachable is what lies `support` above the
// lowest point or higher and does not face the table.
std::vector<deformable::SurfaceSite> surface_sites(const scene::TriangleMesh& surface,
                                                   const tissue::SurfaceDistance& distance, double spacing,
                                                   const Vector3& up, double support);

}  // namespace palpate::physics::organ
