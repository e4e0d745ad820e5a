#include "palpate/physics/deformable/quick_indentation.h"

#include <algorithm>

#include "palpate/physics/deformable/block.h"
#include "palpate/physics/deformable/linear_body.h"
#include "palpate/physics/deformable/surface_load.h"

namespace palpate::physics::deformable {
namespace {

// In tip radii: that of the homogeneous body, and those of what inclusions change.
constexpr double kHomogeneousFootprint = 0.9;
constexpr double kFootprints[] = {0.375, 0.625, 0.9375, 1.25};

Expected<std::vector<double>> answers_of(const Block& block, const Material& material,
                                         const std::vector<double>& footprints) {
  const auto factor = factorised(linear_stiffness(block.mesh, material, block.motion));
  if (!factor) return tl::unexpected(factor.error());
  std::vector<Eigen::VectorXd> loads;
  for (const double a : footprints) loads.push_back(hertz_load(block.mesh, {}, a));
  auto results = answers(*factor, block.motion, loads);
  if (results)
    for (auto& each : *results) each *= block.copies;
  return results;
}

}  // namespace

Expected<SiteLaw> site_law_of_block(const Indentation& it) {
  if (auto good = check(it); !good) return tl::unexpected(good.error());
  const auto block = mesh_block(it, it.radius);
  if (!block) return tl::unexpected(block.error());
  SiteLaw law;
  law.matter = it.material.matrix;
  law.radius = it.radius;
  std::vector<double> footprints{kHomogeneousFootprint * it.radius};
  for (const double share : kFootprints) footprints.push_back(share * it.radius);
  Material bare = it.material;
  bare.inclusions.clear();
  const auto homogeneous = answers_of(*block, bare, footprints);
  if (!homogeneous) return tl::unexpected(homogeneous.error());
  law.homogeneous = homogeneous->front() - half_space_answer(law.matter, footprints.front());
  if (it.material.inclusions.empty()) return law;
  const auto heterogeneous = answers_of(*block, it.material, footprints);
  if (!heterogeneous) return tl::unexpected(heterogeneous.error());
  law.footprints.assign(footprints.begin() + 1, footprints.end());
  for (std::size_t k = 1; k < footprints.size(); ++k)
    law.inclusions.push_back((*heterogeneous)[k] - (*homogeneous)[k]);
  for (const auto& inclusion : it.material.inclusions)
    law.layer = std::min(law.layer, distance_to(inclusion, {0.0, 0.0, 0.0}));
  return law;
}

Expected<std::vector<IndentationPoint>> quick_indentation(const Indentation& it) {
  if (it.model != Model::neo_hookean)
    return wrong_use("indentation: the law of the haptic loop is of neo-Hookean matter alone");
  const auto law = site_law_of_block(it);
  if (!law) return tl::unexpected(law.error());
  std::vector<IndentationPoint> points;
  for (const double depth : it.depths)
    points.push_back({depth, law->force(depth), law->contact_radius(depth)});
  return points;
}

}  // namespace palpate::physics::deformable
