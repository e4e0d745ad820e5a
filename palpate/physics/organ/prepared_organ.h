// A soft organ made ready for the 1 kHz tick: from a closed surface, its matter and the nodules in it to an energy
// over the places of the tip (tissue::TipField) and to the shape that the picture shows.
//
// What depends on the body alone is computed once: a tetrahedral mesh, its linear stiffness, the residual compliance
// at sites all over the surface, what the nodules change of it. With a cache folder the parts are kept there, each
// under the hash of what it was made of; new nodules in a known organ need only their own part. The body's frame, SI.
// Some seconds to half a minute; any thread, one call at a time; a call may run while another organ is being used.
// Source: docs/theory/organ.md.
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/physics/deformable/elasticity.h"
#include "palpate/physics/organ/dent_shape.h"
#include "palpate/physics/tissue/tip_field.h"
#include "palpate/scene/mesh.h"

namespace palpate::physics::organ {

// A ball of other matter inside.
struct Nodule {
  Vector3 centre = Vector3::Zero();  // m
  double radius = 0.0075;            // m
  double ratio = 10.0;               // of its Young's modulus to the organ's
};

struct OrganSettings {
  double young_pa = 6000.0, poisson = 0.45;
  double tip_radius = 0.005;      // m
  double deepest = 0.008;         // m, to which sites are tabulated
  double element = 0.010;         // m, edge of the mesh's elements
  double site_spacing = 0.007;    // m, along the surface
  double support = 0.003;         // m: what lies so far above the lowest point rests on the table and is held
  Vector3 up = Vector3::UnitY();  // unit; the table's normal
  std::vector<Nodule> nodules;
  std::filesystem::path cache;  // a folder; empty: nothing is kept
};

// What it is made of.
deformable::Material matter_of(const OrganSettings& settings);

struct PreparedOrgan {
  scene::TriangleMesh surface;  // as given
  tissue::TipField field;
  DentShape dent;
  bool from_cache = false;  // nothing had to be computed
};

// `progress`: what is being done, and the share of the whole that is; false: it is given up. May be empty.
using OrganProgress = std::function<bool(std::string_view what, double share)>;

// Refused, in words: a surface that is not closed, is too thin for its elements, or stands on nothing; a nodule that
// is not inside; matter that arms of this class cannot render; what was given up. A cache that cannot be written is
// said and does without.
Expected<PreparedOrgan> prepare_organ(const scene::TriangleMesh& surface, const OrganSettings& settings,
                                      const OrganProgress& progress = {});

}  // namespace palpate::physics::organ
