// Where a trial's nodules are: drawn by a seed, so that whoever has organ, settings and seed has them, too. The seed is
// told when the trial is over.
//
// Where a staircase sets how hard a trial is, the seed's lowest four bits are its level and 1, so that the seed alone still
// tells all: size and depth are the level's, the rest is drawn as ever. Frame Body, SI. Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "applications/palpation/settings.h"
#include "palpate/core/expected.h"
#include "palpate/physics/organ/prepared_organ.h"
#include "palpate/scene/mesh.h"

namespace palpate::applications::palpation {

struct HiddenNodule {
  physics::organ::Nodule ball;
  Vector3 above = Vector3::Zero();  // the surface's point nearest to it, by which marks are judged
};

// Of trial 1, 2, ... of a run; 1 to 2^31 - 1. With a level as a staircase has them.
std::int32_t trial_seed(std::uint64_t run_seed, int trial, std::optional<int> level = std::nullopt);
// Of a seed with a level; of any other a level, too.
int level_in_seed(std::int32_t seed);

// Under the upper side's inner part, further apart than twice `apart`, each nearer to its own place above than to the
// underside. Refused where they do not fit.
Expected<std::vector<HiddenNodule>> draw_nodules(const scene::TriangleMesh& organ, const NoduleRanges& ranges,
                                                 double apart, std::int32_t seed);
// The same as the settings have them, by staircase at the seed's level.
Expected<std::vector<HiddenNodule>> draw_nodules(const scene::TriangleMesh& organ,
                                                 const PalpationSettings& settings, std::int32_t seed);

// The upper side's part in which nodules lie and a trainee searches, as an ellipse seen from above.
struct SearchArea {
  double centre_x = 0.0, centre_z = 0.0, half_x = 0.0, half_z = 0.0;  // m
  bool holds(double x, double z) const {
    const double u = (x - centre_x) / half_x, v = (z - centre_z) / half_z;
    return u * u + v * v <= 1.0;
  }
};
SearchArea search_area(const scene::TriangleMesh& organ);

}  // namespace palpate::applications::palpation
