#include "palpate/calibration/pose_refinement.h"

#include <Eigen/LU>
#include <cmath>

#include "palpate/estimation/linear_algebra.h"

namespace palpate {
namespace {

using Matrix26 = Eigen::Matrix<double, 2, 6>;
constexpr double kNearest =
    0.01;  // m in front of the lens: nothing nearer is in focus, and the projection stays finite

struct Term {
  Eigen::Vector2d r;       // px
  Eigen::Matrix2d weight;  // inverse of its covariance
  Matrix26 J;              // d r / d (rotation, translation)
  double squared = 0.0;    // whitened length squared
};

bool evaluate(const CameraModel& camera, const Pose<World, CameraOptical>& X, const Landmark& landmark,
              const Pixel& seen, double pixel_variance, Term& term) {
  const Matrix3 to_camera = X.matrix().transpose();
  const Vector3 arm = landmark.place.m - X.translation;
  const Vector3 p = to_camera * arm;
  if (p.z() < kNearest) return false;
  Eigen::Matrix<double, 2, 3> Jp;
  term.r = project(camera, p, Jp) - seen;
  const Eigen::Matrix<double, 2, 3> JL = Jp * to_camera;  // d r / d landmark
  term.J << JL * hat(arm), -JL;
  const Eigen::Matrix2d S =
      JL * landmark.covariance * JL.transpose() + pixel_variance * Eigen::Matrix2d::Identity();
  term.weight = S.inverse();
  term.squared = term.r.dot(term.weight * term.r);
  return true;
}

struct System {
  Matrix6 A;
  Vector6 b;
  double cost = 0.0;
};

}  // namespace

CameraPosePrior camera_from_marker(const Pose<World, CameraMarker>& X_world_marker,
                                   const Matrix6& marker_covariance, const HandEyeCalibration& hand_eye) {
  CameraPosePrior prior;
  prior.X_world_camera = X_world_marker * hand_eye.X_marker_camera;
  const Matrix3 R = X_world_marker.matrix();
  // R_wc = exp(w) R_wm exp(w') R_mc = exp(w + R_wm w') ...; t_wc = t_wm + exp(w) R_wm (t_mc + d')
  Matrix6 Jm = Matrix6::Identity(), Jh = Matrix6::Zero();
  Jm.bottomLeftCorner<3, 3>() = -hat(R * hand_eye.X_marker_camera.translation);
  Jh.topLeftCorner<3, 3>() = R;
  Jh.bottomRightCorner<3, 3>() = R;
  prior.covariance = Jm * marker_covariance * Jm.transpose() + Jh * hand_eye.covariance * Jh.transpose();
  return prior;
}

RefinedPose refine_camera_pose(const CameraModel& camera, const CameraPosePrior& prior,
                               const std::vector<Landmark>& landmarks, const std::vector<Sighting>& sightings,
                               const RefinementOptions& options) {
  RefinedPose result{prior.X_world_camera, prior.covariance};
  Matrix6 prior_covariance = prior.covariance;
  prior_covariance.diagonal().array() += 1e-18;  // a prior said to be perfect stays invertible
  const Matrix6 information = inverse_symmetric(prior_covariance);
  const double variance = options.pixel_sd * options.pixel_sd;
  std::vector<bool> use(sightings.size(), true);

  const auto system_at = [&](const Pose<World, CameraOptical>& X) {
    System s{information, Vector6::Zero(), 0.0};
    Vector6 e;
    e << so3_log(X.rotation * prior.X_world_camera.rotation.conjugate()),
        X.translation - prior.X_world_camera.translation;
    Matrix6 Je = Matrix6::Identity();
    Je.topLeftCorner<3, 3>() = so3_left_jacobian_inverse(e.head<3>());
    s.A = Je.transpose() * information * Je;
    s.b = Je.transpose() * (information * e);
    s.cost = e.dot(information * e);
    Term term;
    for (std::size_t i = 0; i < sightings.size(); ++i) {
      if (!use[i]) continue;
      if (!evaluate(camera, X, landmarks[sightings[i].landmark], sightings[i].centre, variance, term))
        continue;
      const double length = std::sqrt(term.squared);
      const double w = length <= options.huber ? 1.0 : options.huber / length;
      s.cost += length <= options.huber ? term.squared : options.huber * (2 * length - options.huber);
      const Eigen::Matrix<double, 6, 2> JW = w * term.J.transpose() * term.weight;
      s.A.noalias() += JW * term.J;
      s.b.noalias() += JW * term.r;
    }
    return s;
  };

  Pose<World, CameraOptical> X = prior.X_world_camera;
  System s = system_at(X);
  for (int pass = 0; pass < 2; ++pass) {  // with everything, then without what proved false
    for (int i = 0; i < options.max_iterations; ++i) {
      ++result.iterations;
      const Vector6 step = -solve_symmetric(s.A, s.b);
      double share = 1.0;  // halved where the full step overshoots, as a false sighting may make it
      bool better = false;
      for (int half = 0; half < 5 && !better; ++half, share *= 0.5) {
        const Pose<World, CameraOptical> next{(so3_exp(share * step.head<3>()) * X.rotation).normalized(),
                                              X.translation + share * step.tail<3>()};
        const System t = system_at(next);
        if (!(t.cost <= s.cost * (1 + 1e-12))) continue;
        X = next, s = t, better = true;
      }
      // 1e-7 rad and 1e-7 m are 1e-4 px
      if (!better || (step.head<3>().norm() < 1e-7 && step.tail<3>().norm() < 1e-7)) break;
    }
    result.inliers = 0;
    double sum = 0.0;
    bool changed = false;
    for (std::size_t i = 0; i < sightings.size(); ++i) {
      Term term;
      const bool good =
          evaluate(camera, X, landmarks[sightings[i].landmark], sightings[i].centre, variance, term) &&
          term.squared < options.reject * options.reject;
      changed = changed || good != use[i];
      use[i] = good;
      if (good) sum += term.r.squaredNorm(), ++result.inliers;
    }
    result.rms_px = result.inliers > 0 ? std::sqrt(sum / result.inliers) : 0.0;
    if (result.inliers < options.least_inliers) return result;
    if (!changed) break;
    s = system_at(X);
  }
  result.X_world_camera = X;
  result.covariance = covariance_from_information(s.A);
  result.refined = true;
  return result;
}

}  // namespace palpate
