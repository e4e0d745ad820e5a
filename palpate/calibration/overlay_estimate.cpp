#include "palpate/calibration/overlay_estimate.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "palpate/calibration/landmark_refinement.h"
#include "palpate/estimation/linear_algebra.h"

namespace palpate {
namespace {

constexpr int kAlong = 5, kAcross = 4;  // spots on a surface
constexpr double kLeastDepth = 0.02;    // m: nearer to the camera a spot has no sensible pixel
constexpr Eigen::Index kLensTerms = 9;  // fx fy cx cy k1 k2 p1 p2 k3

CameraModel changed(CameraModel lens, const Eigen::VectorXd& by) {
  lens.fx += by[0], lens.fy += by[1], lens.cx += by[2], lens.cy += by[3];
  for (std::size_t i = 0; i < lens.distortion.size(); ++i)
    lens.distortion[i] += by[4 + static_cast<Eigen::Index>(i)];
  return lens;
}

// d p_camera / d (rotation, translation) of the camera's pose, World axes, left perturbation.
Eigen::Matrix<double, 3, 6> point_in_camera(const Pose<World, CameraOptical>& X, const Vector3& place) {
  const Matrix3 to_camera = X.matrix().transpose();
  Eigen::Matrix<double, 3, 6> J;
  J << to_camera * hat(place - X.translation), -to_camera;
  return J;
}

// By how much the refined pose goes wrong where the lens is `other` instead of the known one.
Vector6 pose_shift(const OverlayKnowledge& known, const RefinedPose& pose, const CameraModel& other,
                   double pixel_sd) {
  Vector6 pull = Vector6::Zero();
  const Pose<CameraOptical, World> X = pose.X_world_camera.inverse();
  const Matrix3 to_camera = pose.X_world_camera.matrix().transpose();
  for (const Sighting& seen : pose.used) {
    const Landmark& landmark = known.landmarks[seen.landmark];
    const Vector3 p = (X * landmark.place).m;
    if (p.z() < kLeastDepth) continue;
    Eigen::Matrix<double, 2, 3> Jp;
    const Pixel here = project(known.lens, p, Jp);
    const Eigen::Matrix<double, 2, 3> JL = Jp * to_camera;
    const Eigen::Matrix2d S = JL * landmark.covariance * JL.transpose() + seen.covariance +
                              pixel_sd * pixel_sd * Eigen::Matrix2d::Identity();
    const Eigen::Matrix<double, 2, 6> J = Jp * point_in_camera(pose.X_world_camera, landmark.place.m);
    pull += J.transpose() * S.inverse() * (here - other.project(p));
  }
  return -pose.covariance * pull;
}

}  // namespace

double OverlayParts::total() const {
  return std::sqrt(pose * pose + landmarks * landmarks + surfaces * surfaces + lens * lens);
}

OverlayKnowledge overlay_knowledge(const Rig& rig) {
  OverlayKnowledge known;
  if (rig.camera) {
    known.lens = rig.camera->model;
    if (rig.camera->covariance.rows() == kLensTerms) {
      const auto [values, vectors] = symmetric_eigen(rig.camera->covariance);
      known.lens_root = vectors * values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
    }
  }
  known.landmarks = rig.landmarks;
  known.landmarks_shared = rig.landmarks_shared;
  if (!rig.landmarks.empty()) {
    std::vector<Vector3> places;
    const auto n = 3 * static_cast<Eigen::Index>(rig.landmarks.size());
    Eigen::MatrixXd each = Eigen::MatrixXd::Zero(n, n);
    for (const Landmark& landmark : rig.landmarks) {
      const auto at = 3 * static_cast<Eigen::Index>(places.size());
      each.block<3, 3>(at, at) = landmark.covariance;
      places.push_back(landmark.place.m);
      known.landmarks_mean += landmark.place.m / static_cast<double>(rig.landmarks.size());
    }
    // Touched and not refined: their errors are their own.
    if (rig.landmarks_shared.isZero(0.0) && places.size() >= 3)
      known.landmarks_shared = shared_motion(places, each);
  }
  for (const auto& surface : rig.surfaces)
    for (int i = 0; i < kAlong; ++i)
      for (int j = 0; j < kAcross; ++j) {
        const double u = (i + 0.5) / kAlong, v = (j + 0.5) / kAcross;
        const Matrix3 R = surface.X_world_rectangle.matrix();
        const Vector3 inside(u * surface.width, v * surface.height, 0.0), arm = R * inside;
        OverlaySpot spot{surface.X_world_rectangle.translation + arm, Matrix3::Zero()};
        if (surface.covariance.rows() == 8) {
          Eigen::Matrix<double, 3, 8> J;
          J << -hat(arm), Matrix3::Identity(), u * R.col(0), v * R.col(1);
          spot.covariance = J * surface.covariance * J.transpose();
        }
        known.spots.push_back(spot);
      }
  return known;
}

std::optional<OverlayParts> expected_overlay(const OverlayKnowledge& known, const RefinedPose& pose,
                                             double pixel_sd) {
  struct Lens {
    CameraModel other;
    Vector6 shift;
  };
  std::vector<Lens> lenses;
  for (Eigen::Index k = 0; k < known.lens_root.cols(); ++k) {
    const CameraModel other = changed(known.lens, known.lens_root.col(k));
    lenses.push_back({other, pose.refined ? pose_shift(known, pose, other, pixel_sd) : Vector6::Zero()});
  }
  const Pose<CameraOptical, World> X = pose.X_world_camera.inverse();
  double by_pose = 0.0, by_landmarks = 0.0, by_surfaces = 0.0, by_lens = 0.0;
  int count = 0;
  for (const OverlaySpot& spot : known.spots) {
    const Vector3 p = (X * Point<World>{spot.place}).m;
    if (p.z() < kLeastDepth) continue;
    const Pixel seen = known.lens.project(p);
    if (seen.x() < 0 || seen.y() < 0 || seen.x() > known.lens.width - 1 || seen.y() > known.lens.height - 1)
      continue;
    // A ray far outside may fold back into the picture; where the lens can be undone it comes back to itself.
    const Pixel drawn = known.lens.project_undistorted(p);
    const auto back = known.lens.undistort_pixel(seen);
    if (!back || (*back - drawn).norm() > 0.01) continue;
    ++count;
    const Eigen::Matrix<double, 2, 3> Jp = projection_jacobian(known.lens, p);
    const Eigen::Matrix<double, 2, 6> JX = Jp * point_in_camera(pose.X_world_camera, spot.place);
    by_pose += (JX * pose.covariance * JX.transpose()).trace();
    const Eigen::Matrix<double, 2, 3> JW = Jp * pose.X_world_camera.matrix().transpose();
    by_surfaces += (JW * spot.covariance * JW.transpose()).trace();
    if (pose.refined) {
      Eigen::Matrix<double, 3, 6> G;
      G << -hat(spot.place - known.landmarks_mean), Matrix3::Identity();
      const Eigen::Matrix<double, 2, 6> JG = JW * G;
      by_landmarks += (JG * known.landmarks_shared * JG.transpose()).trace();
    }
    for (const Lens& lens : lenses) {
      // Were the lens the other one, the real spot would be seen there and drawn here.
      const auto real = known.lens.undistort_pixel(lens.other.project(p));
      if (real) by_lens += (drawn - *real + JX * lens.shift).squaredNorm();
    }
  }
  if (count == 0) return std::nullopt;
  OverlayParts parts;
  parts.pose = std::sqrt(by_pose / count);
  parts.landmarks = std::sqrt(by_landmarks / count);
  parts.surfaces = std::sqrt(by_surfaces / count);
  parts.lens = std::sqrt(by_lens / count);
  return parts;
}

}  // namespace palpate
