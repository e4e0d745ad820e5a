#include "palpate/physics/deformable/surface_load.h"

#include <Eigen/Geometry>
#include <algorithm>
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

}  // namespace

Eigen::VectorXd hertz_load(const TetMesh& mesh, const SurfaceSite& site, double radius) {
  Eigen::VectorXd load = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * mesh.nodes.size()));
  for (const auto& facet : mesh.facets) {
    const auto X = places_of(mesh, facet);
    double extent = 0.0;
    for (int k = 1; k < 6; ++k) extent = std::max(extent, (X.row(k) - X.row(0)).norm());
    if ((X.row(0).transpose() - site.place).norm() > 2.0 * radius + extent) continue;
    // Parts a sixth of the disc's radius or less.
    const int parts = std::clamp(static_cast<int>(std::ceil(6.0 * extent / radius)), 1, kMostParts);
    for (const auto& point : divided_facet_rule(parts)) {
      const auto N = facet_shape(point.L);
      const Eigen::Matrix<double, 3, 2> t = X.transpose() * facet_shape_derivatives(point.L);
      const double facing = 0.5 * Vector3(t.col(0)).cross(Vector3(t.col(1))).dot(site.normal);
      const Vector3 from = X.transpose() * N - site.place;
      const double along = from.dot(site.normal);
      // What faces away, or lies beyond the body, is not the surface that is pressed.
      if (facing <= 0.0 || std::abs(along) > radius) continue;
      const double force =
          point.weight * facing * hertz_pressure((from - along * site.normal).norm(), radius);
      for (int k = 0; k < 6; ++k)
        load.segment<3>(3 * facet[static_cast<std::size_t>(k)]) -= force * N[k] * site.normal;
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
