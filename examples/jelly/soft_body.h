// The jelly's motion: a mass at each vertex of its surface. Springs hold it where it was moulded and to how far its
// neighbours have moved, air inside keeps the volume, and it is slowed as by a thick liquid. All linear in how far the
// vertices have moved, with vertices on the plate held fast. Frame Jelly, SI.
//
// Integrated by the symplectic Euler rule in steps of at most half a millisecond, which is stable as long as
// step^2 * stiffness / mass < 4; the settings' ranges keep it below 1.5, and the constructor checks. One thread;
// nothing but the constructor allocates.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "mould.h"

namespace jelly {

struct Material {
  double firmness = 1.0;  // times the springs of an ordinary jelly
  double damping = 0.10;  // share of the damping with which it would not wobble
};

// Where the vertices are, as both loops hand it to each other.
struct Surface {
  std::array<std::array<float, 3>, kVertices> places{};
  palpate::Vector3 at(std::size_t i) const { return {places[i][0], places[i][1], places[i][2]}; }
};

// How a ball, the tip, meets the surface.
struct Contact {
  static constexpr std::size_t kMost = 64;  // vertices
  double depth = 0.0;                       // so far the ball is below the surface, m; 0: it does not touch
  double share = 0.0;                       // of the ball that has surface under it, 0 to 1
  palpate::Vector3 normal = palpate::Vector3::UnitY();  // out of the surface
  std::size_t count = 0;
  std::array<std::uint32_t, kMost> vertices{};
  std::array<double, kMost> weights{};  // sum 1
};

class SoftBody {
 public:
  // Throws std::invalid_argument for a material that would not be stable.
  explicit SoftBody(const Material& material);

  // For `dt` s, at most 20 ms of it; `force` on the jelly, N, where it is touched.
  void advance(double dt, const Contact& contact, const palpate::Vector3& force);
  void come_to_rest();

  const palpate::scene::TriangleMesh& rest() const { return rest_; }
  palpate::Vector3 place(std::size_t i) const { return rest_.vertices[i] + moved_[i]; }
  void copy_to(Surface& surface) const;
  double volume_gained() const;  // m^3, against the mould; to first order
  double kinetic_energy() const;

 private:
  void step(double h, const Contact& contact, const palpate::Vector3& force);

  palpate::scene::TriangleMesh rest_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_;
  std::vector<palpate::Vector3> areas_, moved_, velocity_, force_;
  double mass_, to_rest_, to_neighbours_, pressure_, drag_;
};

// The contact of a ball of this radius; `surface` and `tip` in the frame Jelly. Any thread; does not allocate.
Contact meet(const Surface& surface, std::span<const palpate::Vector3> facing, const palpate::Vector3& tip,
             double radius);

}  // namespace jelly
