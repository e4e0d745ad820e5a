#include "palpate/physics/deformable/surface_load.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace palpate::physics::deformable {
namespace {

constexpr int kLoadsAtOnce = 32, kMostParts = 16;

// Hertz's pressure of a unit force, at a distance from its axis.
double hertz_pressure(double distance, double radius) {
  const double x = distance / radius;
  return x < 1.0 ? 1.5 / (std::numbers::pi * radius * radius) * std::sqrt(1.0 - x * x) : 0.0;
}

struct FacetSample {
  Eigen::Matrix<double, 6, 1> shape;
  Eigen::Matrix<double, 6, 2> slopes;
  double weight;
};

// Of a facet in parts^2 triangles.
const std::vector<FacetSample>& facet_samples(int parts) {
  static const auto all = [] {
    std::array<std::vector<FacetSample>, kMostParts + 1> rules;
    for (int n = 1; n <= kMostParts; ++n)
      for (const auto& point : divided_facet_rule(n))
        rules[static_cast<std::size_t>(n)].push_back(
            {facet_shape(point.L), facet_shape_derivatives(point.L), point.weight});
    return rules;
  }();
  return all[static_cast<std::size_t>(parts)];
}

}  // namespace

Eigen::VectorXd hertz_load(const TetMesh& mesh, const SurfaceSite& site, double radius) {
  Eigen::VectorXd load = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * mesh.nodes.size()));
  const auto from_axis = [&](const Vector3& from) {
    return (from - from.dot(site.normal) * site.normal).norm();
  };
  for (const auto& facet : mesh.facets) {
    const auto X = places_of(mesh, facet);
    double extent = 0.0;
    for (int k = 1; k < 6; ++k) extent = std::max(extent, (X.row(k) - X.row(0)).norm());
    const Vector3 first = X.row(0).transpose() - site.place;
    if (from_axis(first) > radius + extent || std::abs(first.dot(site.normal)) > radius + extent) continue;
    // Parts a sixth of the disc's radius or less.
    const int parts = std::clamp(static_cast<int>(std::ceil(6.0 * extent / radius)), 1, kMostParts);
    for (const auto& sample : facet_samples(parts)) {
      const Vector3 from = X.transpose() * sample.shape - site.place;
      const double distance = from_axis(from);
      // What faces away, or lies beyond the body, is not the surface that is pressed.
      if (distance >= radius || std::abs(from.dot(site.normal)) > radius) continue;
      const Eigen::Matrix<double, 3, 2> t = X.transpose() * sample.slopes;
      const double facing = 0.5 * Vector3(t.col(0)).cross(Vector3(t.col(1))).dot(site.normal);
      if (facing <= 0.0) continue;
      const double force = sample.weight * facing * hertz_pressure(distance, radius);
      for (int k = 0; k < 6; ++k)
        load.segment<3>(3 * facet[static_cast<std::size_t>(k)]) -= force * sample.shape[k] * site.normal;
    }
  }
  return load;
}

Expected<std::vector<double>> answers(const SparseFactor& factor, const FreeMotion& motion,
                                      const std::vector<Eigen::VectorXd>& loads) {
  std::vector<double> results;
  for (std::size_t first = 0; first < loads.size(); first += kLoadsAtOnce) {
    const std::size_t count = std::min<std::size_t>(kLoadsAtOnce, loads.size() - first);
    Eigen::MatrixXd columns(motion.count(), static_cast<Eigen::Index>(count));
    for (std::size_t k = 0; k < count; ++k)
      columns.col(static_cast<Eigen::Index>(k)) = motion.free_part(loads[first + k]);
    const Eigen::MatrixXd forces = columns;
    if (auto solved = factor.solve(columns); !solved) return tl::unexpected(solved.error());
    for (Eigen::Index k = 0; k < columns.cols(); ++k) results.push_back(forces.col(k).dot(columns.col(k)));
  }
  return results;
}

double half_space_answer(const Elastic& matter, double radius) {
  return 0.6 / (matter.plane_strain() * radius);
}

}  // namespace palpate::physics::deformable
