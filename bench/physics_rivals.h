// The rivals of bench/physics, behind one small interface each: whole steps of ball, table, wall and bat, and
// single sweeps. A rival whose library was not found when configuring is not there: make_...() gives nothing.
#pragma once

#include <memory>
#include <optional>

#include "palpate/math/so3.h"
#include "palpate/scene/mesh.h"

namespace palpate::bench {

// Table of 0.75 x 1 m whose top is y = 0, wall behind it at z = 0, bat a disc of 75 mm by 12 mm, ball of the
// game; restitution 0.93 everywhere, no friction and no air, since not every engine has them.
inline constexpr double kRestitution = 0.93, kRadius = 0.020, kMass = 0.0027, kContact = 0.004;
inline constexpr double kThick = 0.020;  // m, of table and wall where they are boxes

enum class Surfaces { mesh, box };  // two triangles each, or boxes

struct BatPlace {
  Vector3 centre;
  Quaternion rotation;
};

class Engine {
 public:
  virtual ~Engine() = default;
  virtual void place(const Vector3& position, const Vector3& velocity) = 0;
  virtual void step(const BatPlace& before, const BatPlace& after) = 0;
  virtual Vector3 position() const = 0;
  virtual Vector3 velocity() const = 0;
};

struct Setting {
  double dt = 0.001;
  Surfaces surfaces = Surfaces::mesh;
  bool gravity = true;
};

std::unique_ptr<Engine> make_bullet(const Setting& setting);
// MuJoCo has no meshes but convex ones: for Surfaces::mesh it gets planes, which nothing gets behind.
std::unique_ptr<Engine> make_mujoco(const Setting& setting);

class Sweeper {  // of one sphere of radius kRadius, or of a ray
 public:
  virtual ~Sweeper() = default;
  virtual std::optional<double> first(const Vector3& from, const Vector3& to) = 0;  // fraction
};
std::unique_ptr<Sweeper> make_bullet_sweeper(const scene::TriangleMesh& mesh);
std::unique_ptr<Sweeper> make_embree_ray(const scene::TriangleMesh& mesh);

}  // namespace palpate::bench
