#include "palpate/physics/deformable/quick_indentation.h"

#include <algorithm>
#include <limits>
#include <utility>

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

Expected<std::vector<SiteLaw>> site_laws_of_block(const Indentation& indentation,
                                                  std::span<const std::vector<Inclusion>> sets,
                                                  const std::function<void(std::size_t)>& done) {
  Indentation it = indentation;
  it.material.inclusions.clear();
  for (const auto& set : sets)
    it.material.inclusions.insert(it.material.inclusions.end(), set.begin(), set.end());
  if (auto good = check(it); !good) return tl::unexpected(good.error());
  const auto block = mesh_block(it, it.radius);
  if (!block) return tl::unexpected(block.error());
  std::vector<double> footprints{kHomogeneousFootprint * it.radius};
  for (const double share : kFootprints) footprints.push_back(share * it.radius);
  Material matter = it.material;
  matter.inclusions.clear();
  const auto homogeneous = answers_of(*block, matter, footprints);
  if (!homogeneous) return tl::unexpected(homogeneous.error());
  SiteLaw bare;
  bare.matter = it.material.matrix;
  bare.radius = it.radius;
  bare.homogeneous = homogeneous->front() - half_space_answer(bare.matter, footprints.front());
  std::vector<SiteLaw> laws;
  for (const auto& set : sets) {
    laws.push_back(bare);
    if (!set.empty()) {
      matter.inclusions = set;
      const auto heterogeneous = answers_of(*block, matter, footprints);
      if (!heterogeneous) return tl::unexpected(heterogeneous.error());
      SiteLaw& law = laws.back();
      law.footprints.assign(footprints.begin() + 1, footprints.end());
      for (std::size_t k = 1; k < footprints.size(); ++k)
        law.inclusions.push_back((*heterogeneous)[k] - (*homogeneous)[k]);
      double nearest = std::numeric_limits<double>::infinity();
      for (const auto& inclusion : set) {
        const double away = distance_to(inclusion, {0.0, 0.0, 0.0});
        if (away < nearest) law.layer = -(inclusion.centre.z() + inclusion.radii.z());
        nearest = std::min(nearest, away);
      }
    }
    if (done) done(laws.size());
  }
  return laws;
}

Expected<SiteLaw> site_law_of_block(const Indentation& it) {
  const std::vector<std::vector<Inclusion>> own{it.material.inclusions};
  auto laws = site_laws_of_block(it, own);
  if (!laws) return tl::unexpected(laws.error());
  return std::move(laws->front());
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
