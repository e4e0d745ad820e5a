// Where a pointer's ray meets the surface that a hand explores: the place under it, and which way the surface looks
// there. Beside the surface it is the level plane on which the surface stands.
//
// World frame, m. Const after construction; any thread. Throws std::invalid_argument for a mesh that is none.
#pragma once

#include <optional>
#include <vector>

#include "palpate/physics/sweep.h"
#include "palpate/scene/explored_surface.h"

namespace palpate::desktop {

class PointedSurface {
 public:
  struct Place {
    Vector3 at, normal;  // unit; smooth over the surface, as the mean of its vertices' normals
    bool on_surface = false;
  };

  // `up`: unit, out of what the surface stands on.
  PointedSurface(scene::ExploredSurface explored, const Vector3& up);

  // `along`: unit. None where the ray meets neither.
  std::optional<Place> under(const Vector3& eye, const Vector3& along) const;
  const scene::ExploredSurface& explored() const { return explored_; }
  double highest() const { return highest_; }  // of the vertices, along `up`

 private:
  scene::ExploredSurface explored_;
  Vector3 up_;
  double lowest_, highest_;  // of the vertices, along up_
  std::vector<Vector3> normals_;
  physics::CollisionMesh mesh_;
};

}  // namespace palpate::desktop
