#include "palpate/vision/pose_refinement.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/math/linear_algebra.h"

namespace palpate::vision {
namespace {

using Matrix26 = Eigen::Matrix<double, 2, 6>;
constexpr double kNearest =
    0.01;  // m in front of the lens: nothing nearer is in focus, and the projection stays finite

// Passes of rejection, and the share of the worst sighting's length up to which others stay in a pass.
constexpr int kPasses = 8;
constexpr double kPeel = 0.6;

struct Term {
  Eigen::Vector2d r;       // px
  Eigen::Matrix2d weight;  // inverse of its covariance
  Matrix26 J;              // d r / d (rotation, translation)
  double squared = 0.0;    // whitened length squared
};

bool evaluate(const device::CameraModel& camera, const Pose<World, CameraOptical>& X,
              const rig::Landmark& landmark, const Sighting& seen, double pixel_variance, Term& term) {
  const Matrix3 to_camera = X.matrix().transpose();
  const Vector3 arm = landmark.place.m - X.translation;
  const Vector3 p = to_camera * arm;
  if (p.z() < kNearest) return false;
  Eigen::Matrix<double, 2, 3> Jp;
  term.r = device::project(camera, p, Jp) - seen.centre;
  const Eigen::Matrix<double, 2, 3> JL = Jp * to_camera;  // d r / d landmark
  term.J << JL * hat(arm), -JL;
  const Eigen::Matrix2d S = JL * landmark.covariance * JL.transpose() + seen.covariance +
                            pixel_variance * Eigen::Matrix2d::Identity();
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
                                   const Matrix6& marker_covariance,
                                   const rig::HandEyeCalibration& hand_eye) {
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

namespace {

// One refinement: the sightings in use, the pose that fits them and the prior best.
class PoseRefinement {
 public:
  PoseRefinement(const device::CameraModel& camera, const CameraPosePrior& prior,
                 const std::vector<rig::Landmark>& landmarks, const std::vector<Sighting>& sightings,
                 const RefinementOptions& options)
      : camera_(camera),
        prior_(prior),
        landmarks_(landmarks),
        sightings_(sightings),
        options_(options),
        variance_(options.pixel_sd * options.pixel_sd),
        use_(sightings.size(), true),
        X_(prior.X_world_camera) {
    Matrix6 prior_covariance = prior.covariance;
    prior_covariance.diagonal().array() += 1e-18;  // a prior said to be perfect stays invertible
    information_ = inverse_symmetric(prior_covariance);
  }

  RefinedPose refine() {
    RefinedPose result{prior_.X_world_camera, prior_.covariance};
    // With everything, then again and again without what proved false. False sightings pull true ones over the
    // limit: only the worst go at first, and whoever fits again comes back.
    converge(result.iterations);
    for (int pass = 0; pass < kPasses && leave_out_the_worst(); ++pass) converge(result.iterations);
    judge(result);
    if (result.inliers < options_.least_inliers ||
        result.inliers < options_.least_share * static_cast<double>(sightings_.size()))
      return result;
    result.X_world_camera = X_;
    result.covariance = covariance_from_information(system_at(X_).A);
    result.refined = true;
    return result;
  }

 private:
  bool sees(const Pose<World, CameraOptical>& X, std::size_t i, Term& term) const {
    return evaluate(camera_, X, landmarks_[sightings_[i].landmark], sightings_[i], variance_, term);
  }

  System system_at(const Pose<World, CameraOptical>& X) const {
    System s{information_, Vector6::Zero(), 0.0};
    Vector6 e;
    e << so3_log(X.rotation * prior_.X_world_camera.rotation.conjugate()),
        X.translation - prior_.X_world_camera.translation;
    Matrix6 Je = Matrix6::Identity();
    Je.topLeftCorner<3, 3>() = so3_left_jacobian_inverse(e.head<3>());
    s.A = Je.transpose() * information_ * Je;
    s.b = Je.transpose() * (information_ * e);
    s.cost = e.dot(information_ * e);
    Term term;
    for (std::size_t i = 0; i < sightings_.size(); ++i) {
      if (!use_[i] || !sees(X, i, term)) continue;
      const double length = std::sqrt(term.squared), huber = options_.huber;
      const double w = length <= huber ? 1.0 : huber / length;
      s.cost += length <= huber ? term.squared : huber * (2 * length - huber);
      const Eigen::Matrix<double, 6, 2> JW = w * term.J.transpose() * term.weight;
      s.A.noalias() += JW * term.J;
      s.b.noalias() += JW * term.r;
    }
    return s;
  }

  void converge(int& iterations) {
    System s = system_at(X_);
    for (int i = 0; i < options_.max_iterations; ++i) {
      ++iterations;
      const Vector6 step = -solve_symmetric(s.A, s.b);
      double share = 1.0;  // halved where the full step overshoots, as a false sighting may make it
      bool better = false;
      for (int half = 0; half < 5 && !better; ++half, share *= 0.5) {
        const Pose<World, CameraOptical> next{(so3_exp(share * step.head<3>()) * X_.rotation).normalized(),
                                              X_.translation + share * step.tail<3>()};
        const System t = system_at(next);
        if (!(t.cost <= s.cost * (1 + 1e-12))) continue;
        X_ = next, s = t, better = true;
      }
      // 1e-7 rad and 1e-7 m are 1e-4 px
      if (!better || (step.head<3>().norm() < 1e-7 && step.tail<3>().norm() < 1e-7)) break;
    }
  }

  // Whether other sightings are in use now.
  bool leave_out_the_worst() {
    std::vector<double> squared(sightings_.size());
    double worst = 0.0;
    Term term;
    for (std::size_t i = 0; i < sightings_.size(); ++i) {
      squared[i] = sees(X_, i, term) ? term.squared : std::numeric_limits<double>::infinity();
      if (use_[i] && std::isfinite(squared[i])) worst = std::max(worst, squared[i]);
    }
    const double limit = std::max(options_.reject, kPeel * std::sqrt(worst));
    bool changed = false;
    for (std::size_t i = 0; i < sightings_.size(); ++i) {
      const bool good = squared[i] < limit * limit;
      changed = changed || good != use_[i];
      use_[i] = good;
    }
    return changed;
  }

  void judge(RefinedPose& result) {
    double sum = 0.0, whitened = 0.0;
    for (std::size_t i = 0; i < sightings_.size(); ++i) {
      Term term;
      use_[i] = sees(X_, i, term) && term.squared < options_.reject * options_.reject;
      if (!use_[i]) {
        ++result.outliers;
        continue;
      }
      sum += term.r.squaredNorm();
      whitened += term.squared;
      result.used.push_back(sightings_[i]);
    }
    result.inliers = static_cast<int>(result.used.size());
    if (result.inliers == 0) return;
    result.rms_px = std::sqrt(sum / result.inliers);
    result.misfit = std::sqrt(0.5 * whitened / result.inliers);
  }

  const device::CameraModel& camera_;
  const CameraPosePrior& prior_;
  const std::vector<rig::Landmark>& landmarks_;
  const std::vector<Sighting>& sightings_;
  const RefinementOptions& options_;
  double variance_;  // px^2, of a sighting beside its own
  Matrix6 information_;
  std::vector<bool> use_;
  Pose<World, CameraOptical> X_;
};

}  // namespace

RefinedPose refine_camera_pose(const device::CameraModel& camera, const CameraPosePrior& prior,
                               const std::vector<rig::Landmark>& landmarks,
                               const std::vector<Sighting>& sightings, const RefinementOptions& options) {
  return PoseRefinement(camera, prior, landmarks, sightings, options).refine();
}

}  // namespace palpate::vision
