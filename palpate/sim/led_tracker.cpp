#include "palpate/sim/led_tracker.h"

#include <Eigen/LU>

#include "palpate/math/levenberg_marquardt.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::sim {
namespace {

constexpr double kFlattest = 1e-6;  // cameras side by side at a thousandth of the distance
constexpr double kNearest = 0.05;   // m in front of a camera; no lens sees closer

// Closed form with scalar weights; false where the LEDs lie (nearly) in one line.
bool arun(std::span<const Vector3> body, std::span<const LedPoint> seen, BodyFit& fit) {
  Vector3 body_mean = Vector3::Zero(), seen_mean = Vector3::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < body.size(); ++i) {
    const double weight = 1.0 / (seen[i].covariance.trace() + 1e-30);
    body_mean += weight * body[i];
    seen_mean += weight * seen[i].place;
    total += weight;
  }
  body_mean /= total;
  seen_mean /= total;
  Matrix3 H = Matrix3::Zero(), spread = Matrix3::Zero();
  for (std::size_t i = 0; i < body.size(); ++i) {
    const double weight = 1.0 / (seen[i].covariance.trace() + 1e-30) / total;
    H += weight * (seen[i].place - seen_mean) * (body[i] - body_mean).transpose();
    spread += weight * (body[i] - body_mean) * (body[i] - body_mean).transpose();
  }
  const Vector3 shape = symmetric_eigenvalues(spread);
  if (shape[1] < 1e-6 * shape[2] || shape[2] < 1e-12) return false;  // LEDs in one line
  fit.rotation = Quaternion(nearest_rotation(H).rotation).normalized();
  fit.translation = seen_mean - fit.rotation * body_mean;
  return true;
}

}  // namespace

LinearCamera LinearCamera::aimed(const Vector3& place, const Vector3& target, const Vector3& direction) {
  LinearCamera camera;
  camera.place = place;
  camera.forward = (target - place).normalized();
  camera.across = (direction - camera.forward * camera.forward.dot(direction)).normalized();
  return camera;
}

std::optional<LedPoint> triangulate(std::span<const LinearCamera> cameras, std::span<const double> u,
                                    double sd) {
  // Planes (a - u f).(p - c) = 0, first unweighted; a second pass divides each by its depth, which turns the
  // distance to the plane into the error of the measurement. For three cameras both passes give the planes'
  // common point.
  Vector3 p = Vector3::Zero();
  Matrix3 information = Matrix3::Zero();
  const int passes = cameras.size() > 3 ? 3 : 2;
  for (int pass = 0; pass < passes; ++pass) {
    information.setZero();
    Vector3 right = Vector3::Zero();
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      const double depth = pass == 0 ? 1.0 : cameras[i].depth(p);
      if (depth < kNearest) return std::nullopt;
      const Vector3 row = (cameras[i].across - u[i] * cameras[i].forward) / depth;
      information += row * row.transpose();
      right += row * row.dot(cameras[i].place);
    }
    // Product of the eigenvalues against their mean cubed: zero where a direction is not measured at all.
    const double mean = information.trace() / 3.0;
    if (information.determinant() < kFlattest * mean * mean * mean) return std::nullopt;
    p = solve_symmetric(information, right);
  }
  return LedPoint{p, sd * sd * information.inverse()};
}

double triangulation_gain(std::span<const LinearCamera> cameras, const Vector3& p) {
  Matrix3 information = Matrix3::Zero();
  for (const auto& camera : cameras) information += camera.gradient(p) * camera.gradient(p).transpose();
  return std::sqrt(information.inverse().trace());
}

std::optional<BodyFit> fit_body(std::span<const Vector3> body, std::span<const LedPoint> seen) {
  if (body.size() < 3 || body.size() != seen.size()) return std::nullopt;
  BodyFit fit;
  if (!arun(body, seen, fit)) return std::nullopt;
  std::vector<Matrix3> weights;
  weights.reserve(seen.size());
  for (const auto& led : seen) {
    // A perfect tracker has no covariance; every LED then counts the same.
    weights.push_back(led.covariance.trace() > 0 ? Matrix3(led.covariance.inverse()) : Matrix3::Identity());
  }
  const auto evaluate = [&](const BodyFit& at, NormalEquations<6>* equations) {
    double chi2 = 0.0;
    for (std::size_t i = 0; i < body.size(); ++i) {
      const Vector3 arm = at.rotation * body[i];
      const Vector3 r = arm + at.translation - seen[i].place;
      chi2 += r.dot(weights[i] * r);
      if (!equations) continue;
      Eigen::Matrix<double, 3, 6> J;
      J << -hat(arm), Matrix3::Identity();
      const Eigen::Matrix<double, 6, 3> JW = J.transpose() * weights[i];
      equations->JtJ += JW * J;
      equations->Jtr += JW * r;
    }
    return chi2;
  };
  const auto moved = [](const BodyFit& at, const Vector6& step) {
    BodyFit next = at;
    next.rotation = (so3_exp(step.head<3>()) * at.rotation).normalized();
    next.translation += step.tail<3>();
    return next;
  };
  minimise<6>(fit, evaluate, moved, {.most_iterations = 10, .tolerance = 1e-6});
  NormalEquations<6> found;
  fit.chi2 = evaluate(fit, &found);
  if (!(fit.translation.norm() < 1e6)) return std::nullopt;
  fit.covariance =
      seen.front().covariance.trace() > 0 ? Matrix6(inverse_symmetric(found.JtJ)) : Matrix6::Zero();
  return fit;
}

Matrix3 point_covariance(const Quaternion& rotation, const Matrix6& pose_covariance, const Vector3& p_body) {
  Eigen::Matrix<double, 3, 6> J;
  J << -hat(rotation * p_body), Matrix3::Identity();
  return J * pose_covariance * J.transpose();
}

}  // namespace palpate::sim
