#include "palpate/calibration/internal/pivot_sphere.h"

#include <algorithm>
#include <cmath>

#include "palpate/math/levenberg_marquardt.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {

namespace {

// Each centre and the mean radius by the linear equations of Coope (1993).
Expected<PivotSphere> start_spheres(const PivotData& data) {
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
  return sphere;
}

// Centres, then the radius.
using SphereEquations = NormalEquations<Eigen::Dynamic>;

double sphere_cost(const PivotData& data, const Eigen::VectorXd& x, SphereEquations* equations) {
  const Eigen::Index last = x.size() - 1;
  double cost = 0.0;
  for (std::size_t i = 0; i < data.size(); ++i) {
    const auto at = 3 * static_cast<Eigen::Index>(data.segment[i]);
    const Vector3 d = data.p[i] - data.motion[i] - x.segment<3>(at);
    const double distance = d.norm(), r = distance - x[last];
    cost += r * r;
    if (!equations) continue;
    const Vector3 J = -d / distance;  // by the centre; -1 by the radius
    equations->JtJ.block<3, 3>(at, at) += J * J.transpose();
    equations->JtJ.block<1, 3>(last, at) -= J.transpose();
    equations->JtJ(last, last) += 1.0;
    equations->Jtr.segment<3>(at) += J * r;
    equations->Jtr[last] -= r;
  }
  return cost;
}

}  // namespace

Expected<PivotSphere> fit_spheres(const PivotData& data) {
  auto sphere = start_spheres(data);
  if (!sphere) return sphere;
  const auto S = static_cast<Eigen::Index>(data.segments);
  Eigen::VectorXd x(3 * S + 1);
  for (Eigen::Index s = 0; s < S; ++s) x.segment<3>(3 * s) = sphere->centres[static_cast<std::size_t>(s)];
  x[3 * S] = sphere->radius;
  const auto evaluate = [&](const Eigen::VectorXd& at, SphereEquations* equations) {
    return sphere_cost(data, at, equations);
  };
  const auto solved = minimise(x, evaluate);
  if (!solved.converged || !x.allFinite())
    return refused("pivot: the sphere fit does not converge on these poses; use --method algebraic");
  for (Eigen::Index s = 0; s < S; ++s) sphere->centres[static_cast<std::size_t>(s)] = x.segment<3>(3 * s);
  sphere->radius = x[3 * S];
  SphereEquations found(3 * S + 1);
  evaluate(x, &found);
  sphere->normal = found.JtJ.selfadjointView<Eigen::Lower>();
  return sphere;
}

}  // namespace palpate::calibration
