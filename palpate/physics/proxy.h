// The sphere that stays on a surface while the tip that leads it goes beneath: what a hand feels of a rigid
// mesh.
//
// The proxy goes where the tip is as long as nothing is in its way, and else to the place nearest to the tip
// that a sphere can reach without passing through a triangle. All constraints are found within one call, so
// that a tip at rest gives a force at rest. With friction it stays behind that place by up to `friction`
// times the depth, and does not begin to slide below `static_friction`. All in the MESH's frame, SI: of a
// mesh that moves the path of the tip as seen from it is given, and the proxy rides with it. One thread;
// follow() allocates nothing and throws nothing. Source: Zilles and Salisbury 1995 (god-object), Ruspini,
// Kolarov and Khatib 1997 (sphere; move, constrain, slide), Melder and Harwin 2004 (cone of friction);
// docs/theory/proxy.md.
#pragma once

#include <array>
#include <cstddef>

#include "palpate/physics/sweep.h"

namespace palpate::physics {

struct ProxySettings {
  double radius = 0.003;         // m, > 0
  double friction = 0.0;         // tangential over normal force while it slides, 0 to 2
  double static_friction = 0.0;  // until it does; below `friction` it counts as that
  int most_sweeps = 64;          // per call; a proxy that needs more goes on in the next
};

struct ProxyState {
  Vector3 position = Vector3::Zero();  // of the sphere's centre
  Vector3 normal = Vector3::Zero();    // unit, out of the surface, as the contacts together push; 0: free
  double depth = 0.0;                  // m, of the tip along the normal
  bool touching = false;
  bool sliding = false;  // touching, and the cone of friction has been left
  bool settled = true;   // false: most_sweeps was not enough
  int sweeps = 0;        // that were made
};

class Proxy {
 public:
  // Throws std::invalid_argument for settings out of range. The mesh must outlive the proxy.
  Proxy(const CollisionMesh& mesh, const ProxySettings& settings);

  // True where a sphere at `p` is clear of every triangle: where a proxy may begin.
  bool clear_at(const Vector3& p) const;
  // Begins there, free. A proxy begun in overlap is pushed out on whichever side its centre is.
  void begin(const Vector3& p);
  // Goes after the tip. A tip that is not finite leaves everything as it is.
  const ProxyState& follow(const Vector3& tip);

  const ProxyState& state() const { return state_; }
  const ProxySettings& settings() const { return settings_; }

 private:
  struct Plane {  // normal . x >= offset keeps the centre out of the triangle that was touched
    Vector3 normal;
    double offset;
  };
  static constexpr std::size_t kPlanes = 8;

  void constrain(const SweepHit& hit);
  bool allowed(const Vector3& x) const;
  Vector3 nearest_allowed(const Vector3& goal, const Vector3& here) const;
  bool go(Vector3& x, const Vector3& to);
  void slide(Vector3& x, const Vector3& goal);

  const CollisionMesh& mesh_;
  ProxySettings settings_;
  double skin_, still_;  // m
  ProxyState state_;
  std::array<Plane, kPlanes> planes_;
  std::size_t plane_count_ = 0;
};

}  // namespace palpate::physics
