// Soft bodies whose forces are known in closed form, for tests: a half-space's law, stiffer by a share that varies
// over the surface, as over something hard inside.
//
//   F(d) = 4/3 E* sqrt(R) d^1.5 (1 - k d / R) share(place),  k = 0.124 (nu 0.45)
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "palpate/math/so3.h"
#include "palpate/physics/tissue/tip_field.h"
#include "palpate/scene/mesh.h"

namespace palpate::physics::tissue {

struct SoftForTests {
  double young = 6000.0, poisson = 0.45, radius = 0.008;  // Pa, 1, m
  double large_strain = 0.124;
  std::function<double(const Vector3&)> share = [](const Vector3&) { return 1.0; };

  double scale() const { return 4.0 / 3.0 * young / (1.0 - poisson * poisson) * std::sqrt(radius); }
  double force(const Vector3& place, double d) const {
    return d <= 0.0 ? 0.0 : scale() * std::pow(d, 1.5) * (1.0 - large_strain * d / radius) * share(place);
  }
  double energy(const Vector3& place, double d) const {
    return d <= 0.0
               ? 0.0
               : scale() * share(place) * std::pow(d, 2.5) * (0.4 - 2.0 / 7.0 * large_strain * d / radius);
  }
  double tangent(const Vector3& place, double d) const {
    return d <= 0.0 ? 0.0 : scale() * share(place) * std::sqrt(d) * (1.5 - 2.5 * large_strain * d / radius);
  }
  EnergySite site(const Vector3& place, const Vector3& normal, double deepest) const {
    EnergySite site{place, normal, {}, {}};
    for (int i = 1; i <= 12; ++i) {
      site.depth_m.push_back(deepest * i / 12.0);
      site.energy_j.push_back(energy(place, site.depth_m.back()));
    }
    return site;
  }
};

// Young's modulus at which a homogeneous body is so stiff at this depth.
inline double young_for_tests(double tangent_n_m, double depth, double radius = SoftForTests{}.radius) {
  const SoftForTests like{.radius = radius};
  return like.young * tangent_n_m / like.tangent(Vector3::Zero(), depth);
}

// More by `more` above a point, in a bump of standard deviation `width`.
inline std::function<double(const Vector3&)> bump_for_tests(const Vector3& at, double more, double width) {
  return [=](const Vector3& p) {
    return 1.0 + more * std::exp(-0.5 * (p - at).squaredNorm() / (width * width));
  };
}

// On all faces of the box, `apart` from one another and half of that from the edges.
inline std::vector<EnergySite> box_sites_for_tests(const Vector3& half, const SoftForTests& soft,
                                                   double apart, double deepest) {
  std::vector<EnergySite> sites;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Eigen::Index u = (axis + 1) % 3, v = (axis + 2) % 3;
    const int nu = std::max(2, static_cast<int>(std::lround(2.0 * half[u] / apart)));
    const int nv = std::max(2, static_cast<int>(std::lround(2.0 * half[v] / apart)));
    for (const double side : {-1.0, 1.0})
      for (int i = 0; i < nu; ++i)
        for (int j = 0; j < nv; ++j) {
          Vector3 place;
          place[axis] = side * half[axis];
          place[u] = half[u] * (2.0 * i + 1.0 - nu) / nu;
          place[v] = half[v] * (2.0 * j + 1.0 - nv) / nv;
          sites.push_back(soft.site(place, side * Vector3::Unit(axis), deepest));
        }
  }
  return sites;
}

// A block, its top at z = half.z.
inline Expected<TipField> block_for_tests(const SoftForTests& soft, const Vector3& half = {0.05, 0.04, 0.02},
                                          double deepest = 0.006, double apart = 0.007) {
  return TipField::build(scene::box_mesh(-half, half), box_sites_for_tests(half, soft, apart, deepest),
                         {.tip_radius = soft.radius});
}

}  // namespace palpate::physics::tissue
