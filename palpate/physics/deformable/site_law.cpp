#include "palpate/physics/deformable/site_law.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace palpate::physics::deformable {
namespace {

constexpr double kFootprintShrink = 0.1;
constexpr double kGrowthOfLayer = 0.187, kGrowthOfTip = 0.26;
constexpr double kGrownTo = 1.6;  // layers, of depth
constexpr double kDeepest = 1.5;  // half-space depth in tip radii: the search for it ends there

// Of a tip on a flat place that touches as wide.
double relative_radius(double radius, double curvature) { return radius / (1.0 + radius * curvature); }

double half_space_force(const SiteLaw& law, double delta) {
  const double k = finite_strain_softening(law.matter.poisson);
  return 4.0 / 3.0 * law.matter.plane_strain() *
         std::sqrt(relative_radius(law.radius, law.curvature) * delta) * delta *
         (1.0 - k * delta / law.radius);
}

double half_space_stiffness(const SiteLaw& law, double delta) {
  const double k = finite_strain_softening(law.matter.poisson);
  return 4.0 / 3.0 * law.matter.plane_strain() *
         std::sqrt(relative_radius(law.radius, law.curvature) * delta) * (1.5 - 2.5 * k * delta / law.radius);
}

}  // namespace

double finite_strain_softening(double poisson) {
  constexpr std::array<std::array<double, 2>, 4> kTable{
      {{0.40, 0.076}, {0.45, 0.124}, {0.48, 0.156}, {0.49, 0.168}}};
  std::size_t i = 0;
  while (i + 2 < kTable.size() && poisson > kTable[i + 1][0]) ++i;
  const auto& [from, to] = std::array{kTable[i], kTable[i + 1]};
  return from[1] + (to[1] - from[1]) * (poisson - from[0]) / (to[0] - from[0]);
}

double footprint(double radius, double depth, double curvature) {
  return depth > 0.0 ? std::sqrt(relative_radius(radius, curvature) * depth) *
                           (1.0 - kFootprintShrink * depth / radius)
                     : 0.0;
}

double SiteLaw::compliance(double a, double growth, double& slope) const {
  slope = 0.0;
  if (footprints.empty()) return homogeneous;
  std::size_t i = 0;
  while (i + 2 < footprints.size() && a > footprints[i + 1]) ++i;
  if (footprints.size() == 1 || a <= footprints.front()) return homogeneous + growth * inclusions.front();
  if (a >= footprints.back()) return homogeneous + growth * inclusions.back();
  slope = growth * (inclusions[i + 1] - inclusions[i]) / (footprints[i + 1] - footprints[i]);
  return homogeneous + growth * inclusions[i] + slope * (a - footprints[i]);
}

double SiteLaw::whole_depth(double delta, double growth) const {
  if (!(delta > 0.0)) return 0.0;
  const double a = footprint(radius, delta, curvature), force = half_space_force(*this, delta);
  double slope = 0.0;
  const double c = compliance(a, growth, slope);
  const double widening = std::sqrt(relative_radius(radius, curvature)) *
                          (0.5 / std::sqrt(delta) - 1.5 * kFootprintShrink * std::sqrt(delta) / radius);
  return delta + force * c + 0.5 * force * force * slope * widening / half_space_stiffness(*this, delta);
}

double SiteLaw::half_space_depth(double depth) const {
  const double growth =
      std::isfinite(layer) && layer > 0.0
          ? 1.0 + (kGrowthOfLayer / layer + kGrowthOfTip / radius) * std::min(depth, kGrownTo * layer)
          : 1.0;
  double low = 0.0, high = kDeepest * radius;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (whole_depth(middle, growth) < depth ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double SiteLaw::force(double depth) const {
  return depth > 0.0 ? half_space_force(*this, half_space_depth(depth)) : 0.0;
}

double SiteLaw::contact_radius(double depth) const {
  return depth > 0.0 ? footprint(radius, half_space_depth(depth), curvature) : 0.0;
}

// Gauss-Legendre in the root of depth, in which the force is smooth at the first touch.
double SiteLaw::energy(double depth) const {
  if (!(depth > 0.0)) return 0.0;
  constexpr std::array<double, 4> kPlaces{0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                          0.9602898564975363};
  constexpr std::array<double, 4> kWeights{0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                           0.1012285362903763};
  double sum = 0.0;
  const double half = 0.5 * std::sqrt(depth);
  for (std::size_t k = 0; k < 4; ++k)
    for (const double side : {-1.0, 1.0}) {
      const double root = half * (1.0 + side * kPlaces[k]);
      sum += kWeights[k] * half * 2.0 * root * force(root * root);
    }
  return sum;
}

}  // namespace palpate::physics::deformable
