// What a soft body answers to the tip of a stylus, prepared for the 1 kHz tick: an energy over the places of the
// tip's centre, and its gradient as the force.
//
//   W(p) = kappa(p) d(p)^2.5,  F(p) = -grad W;  both exactly zero where d <= 0
// d is the depth of a sphere of the tip's radius, radius minus signed distance to the undeformed surface; kappa is
// nearly constant, so that both are smooth and two splines hold them. The force is continuous and the exact gradient
// of the energy: no way around any closed path gives out work.
//
// Beyond `deepest` the stiffness stays as it is there. Where two sides of a body are equally near, at its
// middle, the energy has a ridge: beyond it the field pushes out through the other side, which is why whoever
// follows a tip lets go there (TipEnergy::lost, TissueLaw). Body's frame, SI. Const, any thread; at() allocates
// nothing and takes the same time everywhere.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "palpate/core/expected.h"
#include "palpate/physics/tissue/energy_site.h"
#include "palpate/physics/tissue/spline_field.h"
#include "palpate/scene/mesh.h"

namespace palpate::physics::tissue {

// What arms of this class render with a force a tick late (docs/theory/tissue.md).
inline constexpr double kMostTangent_n_m = 700.0;

struct TipFieldSettings {
  double tip_radius = 0.005;                   // m
  double spacing = 0.002;                      // m, of the lattice
  double deepest = 0.0;                        // m; 0: as deep as the sites know
  double most_tangent_n_m = kMostTangent_n_m;  // a body that is stiffer anywhere is refused
};

struct TipEnergy {
  double depth = 0.0;                // m; 0 outside
  double energy = 0.0;               // J
  Vector3 force = Vector3::Zero();   // N
  Vector3 normal = Vector3::Zero();  // outwards, unit; zero outside
  double tangent = 0.0;              // N/m along the normal, of kappa as it is here
  bool lost =
      false;  // too deep, or where the body's sides are equally near: which side the tip came from cannot be
              // told from its place
};

// What a field was made for, and what it turned out to be.
struct TipFieldFacts {
  double tip_radius = 0.0, deepest = 0.0;  // m
  double stiffest_n_m = 0.0;               // largest tangent, along the normal, down to `deepest`
  double strongest_n = 0.0;                // largest force where a tip is not lost
};

class TipField {
 public:
  // Refused: a surface that is not closed, sites that make no sense, a body that is too stiff somewhere, a lattice
  // that would take more than kMostTissueBytes; the words say what to change.
  static Expected<TipField> build(const scene::TriangleMesh& surface, std::span<const EnergySite> sites,
                                  const TipFieldSettings& settings);
  // Of parts made before (tip_field_file.h). Throws std::invalid_argument for facts that cannot be.
  TipField(const TipFieldFacts& facts, SplineFields<2> fields);

  TipEnergy at(const Vector3& p) const;

  const TipFieldFacts& facts() const { return facts_; }
  const SplineFields<2>& fields() const { return fields_; }

 private:
  void measure();

  TipFieldFacts facts_;
  SplineFields<2> fields_;  // d, kappa
  double lost_depth_ = 0.0;
};

inline constexpr std::size_t kMostTissueBytes = 64'000'000;

// From all that a field is built of, 16 hex digits: whether one in a cache is the one that is wanted.
std::string tip_field_key(const scene::TriangleMesh& surface, std::span<const EnergySite> sites,
                          const TipFieldSettings& settings);

}  // namespace palpate::physics::tissue
