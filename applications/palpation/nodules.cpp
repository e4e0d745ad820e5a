#include "applications/palpation/nodules.h"

#include <algorithm>
#include <cmath>

#include "applications/palpation/difficulty.h"
#include "applications/palpation/liver.h"
#include "palpate/core/random.h"
#include "palpate/core/units.h"
#include "palpate/physics/tissue/surface_distance.h"

namespace palpate::applications::palpation {
namespace {

constexpr double kInner = 0.62;       // share of the organ's half sides
constexpr double kLevelAbove = 0.85;  // least upward part of the normal above a nodule
constexpr double kCover_m = 0.003;    // least matter between a nodule and any other side
constexpr int kMostDraws = 400;
constexpr std::int32_t kLevelBits = 15;  // of a seed that tells the level
static_assert(kHardestLevel + 1 <= kLevelBits);

// The outer points of a nodule are no nearer to another side than kCover_m, and to its own as deep as was drawn.
bool lies_inside(const physics::tissue::SurfaceDistance& surface, const HiddenNodule& nodule, double depth) {
  const auto nearest = surface.at(nodule.ball.centre);
  constexpr double kOffAxis_m = 0.001;
  return nearest.distance < 0.0 && std::abs(-nearest.distance - nodule.ball.radius - depth) < kOffAxis_m &&
         nodule.ball.centre.y() - nodule.ball.radius > kCover_m;
}

}  // namespace

std::int32_t trial_seed(std::uint64_t run_seed, int trial, std::optional<int> level) {
  Random random(run_seed + 0x9e3779b97f4a7c15ull * static_cast<std::uint64_t>(trial), "palpation/trial");
  const auto seed = static_cast<std::int32_t>(1 + random.below(0x7ffffffe));
  return level ? (seed & ~kLevelBits) | (std::clamp(*level, 0, kHardestLevel) + 1) : seed;
}

int level_in_seed(std::int32_t seed) { return std::clamp((seed & kLevelBits) - 1, 0, kHardestLevel); }

SearchArea search_area(const scene::TriangleMesh& organ) {
  Vector3 low = organ.vertices.front(), high = low;
  for (const auto& v : organ.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  return {0.5 * (low.x() + high.x()), 0.5 * (low.z() + high.z()), 0.5 * kInner * (high.x() - low.x()),
          0.5 * kInner * (high.z() - low.z())};
}

Expected<std::vector<HiddenNodule>> draw_nodules(const scene::TriangleMesh& organ, const NoduleRanges& ranges,
                                                 double apart, std::int32_t seed) {
  auto surface = physics::tissue::SurfaceDistance::of(organ);
  if (!surface) return tl::unexpected(surface.error());
  const auto normals = vertex_normals(organ);
  const SearchArea area = search_area(organ);
  Random random(static_cast<std::uint64_t>(seed), "palpation/nodules");
  const auto count = static_cast<std::size_t>(
      ranges.fewest +
      static_cast<int>(random.below(static_cast<std::uint64_t>(ranges.most - ranges.fewest + 1))));
  std::vector<HiddenNodule> nodules;
  for (int tries = 0; nodules.size() < count; ++tries) {
    if (tries == kMostDraws)
      return refused(
          "palpation: {} nodules of {:.0f} to {:.0f} mm, {:.0f} to {:.0f} mm deep, do not fit under the "
          "upper side; "
          "choose fewer, smaller or shallower ones",
          count, mm_from_metres(ranges.diameter[0]), mm_from_metres(ranges.diameter[1]),
          mm_from_metres(ranges.depth[0]), mm_from_metres(ranges.depth[1]));
    const auto i = static_cast<std::size_t>(random.below(organ.vertices.size()));
    const double depth = random.uniform(ranges.depth[0], ranges.depth[1]);
    HiddenNodule nodule;
    nodule.above = organ.vertices[i];
    nodule.ball.radius = 0.5 * random.uniform(ranges.diameter[0], ranges.diameter[1]);
    nodule.ball.ratio = random.uniform(ranges.ratio[0], ranges.ratio[1]);
    nodule.ball.centre = nodule.above - (nodule.ball.radius + depth) * normals[i];
    if (normals[i].y() < kLevelAbove || !area.holds(nodule.above.x(), nodule.above.z())) continue;
    const bool near = std::any_of(nodules.begin(), nodules.end(), [&](const HiddenNodule& other) {
      return (other.above - nodule.above).norm() <= 2.0 * apart ||
             (other.ball.centre - nodule.ball.centre).norm() <=
                 other.ball.radius + nodule.ball.radius + kCover_m;
    });
    if (!near && lies_inside(*surface, nodule, depth)) nodules.push_back(nodule);
  }
  return nodules;
}

Expected<std::vector<HiddenNodule>> draw_nodules(const scene::TriangleMesh& organ,
                                                 const PalpationSettings& settings, std::int32_t seed) {
  const bool by_level = settings.difficulty == Difficulty::staircase;
  return draw_nodules(organ, by_level ? ranges_at(settings.nodules, level_in_seed(seed)) : settings.nodules,
                      settings.rules.within, seed);
}

}  // namespace palpate::applications::palpation
