#include "palpate/calibration/internal/pivot_sphere.h"

#include <algorithm>
#include <cmath>

#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {

Expected<PivotSphere> fit_spheres(const PivotData& data) {
  const auto S = static_cast<Eigen::Index>(data.segments);
  PivotSphere sphere;
  const auto mean = segment_means(data, Vector3(Vector3::Zero()), [&](std::size_t i) { return data.p[i]; });
  for (std::size_t s = 0; s < data.segments; ++s) {
    Eigen::Matrix4d N = Eigen::Matrix4d::Zero();
    Eigen::Vector4d b = Eigen::Vector4d::Zero();
    double count = 0.0;
    for (std::size_t i = 0; i < data.size(); ++i) {
      if (data.segment[i] != s) continue;
      const Vector3 q = data.p[i] - data.motion[i] - mean[s];
      const Eigen::Vector4d row(2.0 * q.x(), 2.0 * q.y(), 2.0 * q.z(), 1.0);
      N += row * row.transpose();
      b += row * q.squaredNorm();
      count += 1.0;
    }
    const Matrix3 spread = N.topLeftCorner<3, 3>() / (4.0 * std::max(count, 1.0));
    const Vector3 axes = symmetric_eigenvalues(spread);
    if (count < 4.0 || !(axes[0] > 1e-6 * axes[2]))
      return refused(
          "pivot: the marker's origins ({} of them) lie in a plane, so no sphere is determined; swing the "
          "marker in two directions, or use --method algebraic",
          count);
    const Eigen::Vector4d solution = solve_symmetric(N, b);
    sphere.centres.push_back(mean[s] + solution.head<3>());
    sphere.radius +=
        std::sqrt(std::max(0.0, solution[3] + solution.head<3>().squaredNorm())) / static_cast<double>(S);
  }
  for (int iteration = 0; iteration < 100; ++iteration) {
    sphere.normal = Eigen::MatrixXd::Zero(3 * S + 1, 3 * S + 1);
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(3 * S + 1);
    for (std::size_t i = 0; i < data.size(); ++i) {
      const Vector3 d = data.p[i] - data.motion[i] - sphere.centres[data.segment[i]];
      const double distance = d.norm();
      Eigen::VectorXd J = Eigen::VectorXd::Zero(3 * S + 1);
      J.segment<3>(3 * static_cast<Eigen::Index>(data.segment[i])) = -d / distance;
      J[3 * S] = -1.0;
      sphere.normal += J * J.transpose();
      gradient += J * (distance - sphere.radius);
    }
    const Eigen::VectorXd step = solve_symmetric(sphere.normal, -gradient);
    if (!step.allFinite()) return refused("pivot: the sphere fit does not converge; use --method algebraic");
    for (Eigen::Index s = 0; s < S; ++s)
      sphere.centres[static_cast<std::size_t>(s)] += step.segment<3>(3 * s);
    sphere.radius += step[3 * S];
    if (step.norm() < 1e-13) return sphere;
  }
  return refused("pivot: the sphere fit does not converge on these poses; use --method algebraic");
}

}  // namespace palpate::calibration
