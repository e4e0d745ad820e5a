#include "palpate/vision/pose_refinement.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/math/linear_algebra.h"
#include "palpate/math/pose_step.h"

namespace palpate::vision {
namespace {

using Matrix26 = Eigen::Matrix<double, 2, 6>;
constexpr double kNearest =
    0.01;  // m in front of the lens: nothing nearer is in focus, and the projection stays finite

// Passes of rejection, and the share of the worst sighting's length up to which others stay in a pass.
constexpr int kPasses = 8;
constexpr double kPeel = 0.6;
// Of the residuals' length, by which the last step changes them: some ten-thousandth of a standard deviation,
// and what is left after it a hundredth of that.
constexpr double kTolerance = 1e-5;

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
        known_(prior.X_world_camera, prior.covariance),
        use_(sightings.size(), true),
        X_(prior.X_world_camera) {}

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
    NormalEquations<6> at;
    cost_at(X_, &at);
    result.covariance = covariance_from_information(at.JtJ);
    result.refined = true;
    return result;
  }

 private:
  bool sees(const Pose<World, CameraOptical>& X, std::size_t i, Term& term) const {
    return evaluate(camera_, X, landmarks_[sightings_[i].landmark], sightings_[i], variance_, term);
  }

  double cost_at(const Pose<World, CameraOptical>& X, NormalEquations<6>* equations) const {
    double cost = equations ? known_.add(X, equations->JtJ, equations->Jtr) : known_.cost(X);
    Term term;
    for (std::size_t i = 0; i < sightings_.size(); ++i) {
      if (!use_[i] || !sees(X, i, term)) continue;
      const Robust robust = huber(term.squared, options_.huber);
      cost += robust.loss;
      if (!equations) continue;
      const Eigen::Matrix<double, 6, 2> JW = robust.weight * term.J.transpose() * term.weight;
      equations->JtJ.noalias() += JW * term.J;
      equations->Jtr.noalias() += JW * term.r;
    }
    return cost;
  }

  void converge(int& iterations) {
    const auto at = [this](const Pose<World, CameraOptical>& X, NormalEquations<6>* equations) {
      return cost_at(X, equations);
    };
    iterations += minimise<6>(X_, at, moved<World, CameraOptical>,
                              {.most_iterations = options_.max_iterations, .tolerance = kTolerance})
                      .iterations;
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
  PosePrior<World, CameraOptical> known_;
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
