#include "palpate/vision/overlay_estimate.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "palpate/math/linear_algebra.h"

namespace palpate::vision {
namespace {

constexpr int kAlong = 5, kAcross = 4;  // spots on a surface
constexpr double kLeastDepth = 0.02;    // m: nearer to the camera a spot has no sensible pixel
constexpr Eigen::Index kHandEyeAt = device::kLensParameters, kLandmarksAt = kHandEyeAt + 6;

// d p_camera / d (rotation, translation) of the camera's pose, World axes, left perturbation.
Eigen::Matrix<double, 3, 6> point_in_camera(const Pose<World, CameraOptical>& X, const Vector3& place) {
  const Matrix3 to_camera = X.matrix().transpose();
  Eigen::Matrix<double, 3, 6> J;
  J << to_camera * hat(place - X.translation), -to_camera;
  return J;
}

// What the errors of registration make of the pose, 6 x (15 + 3 n), and the covariance of what a picture's
// own noise does.
struct PoseErrorSources {
  Eigen::MatrixXd by_registration;
  Matrix6 by_picture = Matrix6::Zero();
};

PoseErrorSources pose_error_sources(const OverlayKnowledge& known, const OverlayPicture& picture) {
  const auto& [prior, tracker, pose, pixel_sd] = picture;
  const Pose<World, CameraOptical>& X = pose.X_world_camera;
  PoseErrorSources errors{Eigen::MatrixXd::Zero(6, known.registration.cols())};
  // The hand-eye transform is perturbed in the marker's axes.
  const Matrix3 R_world_marker = X.matrix() * known.R_marker_camera.toRotationMatrix().transpose();
  Matrix6 by_hand_eye = Matrix6::Zero();
  by_hand_eye.topLeftCorner<3, 3>() = by_hand_eye.bottomRightCorner<3, 3>() = R_world_marker;
  if (!pose.refined) {
    errors.by_registration.middleCols<6>(kHandEyeAt) = by_hand_eye;
    errors.by_picture = tracker;
    return errors;
  }
  // At the true pose the refinement's equations hold the prior's error e0 and each sighting's residual r;
  // their solution is off by P (P0^-1 e0 - sum J' S^-1 r).
  const Matrix6& P = pose.covariance;
  const Matrix6 pull = P * inverse_symmetric(prior.covariance + 1e-18 * Matrix6::Identity());
  errors.by_registration.middleCols<6>(kHandEyeAt) = pull * by_hand_eye;
  errors.by_picture = pull * tracker * pull.transpose();
  const Pose<CameraOptical, World> to_camera = X.inverse();
  for (const Sighting& seen : pose.used) {
    const rig::Landmark& landmark = known.landmarks[seen.landmark];
    const Vector3 p = (to_camera * landmark.place).m;
    if (p.z() < kLeastDepth) continue;
    Eigen::Matrix<double, 2, 3> Jp;
    device::project(known.lens, p, Jp);
    const Eigen::Matrix<double, 2, 3> JL = Jp * X.matrix().transpose();
    const Eigen::Matrix2d noise = seen.covariance + pixel_sd * pixel_sd * Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d S = JL * landmark.covariance * JL.transpose() + noise;
    const Eigen::Matrix<double, 6, 2> gain =
        P * (Jp * point_in_camera(X, landmark.place.m)).transpose() * S.inverse();
    errors.by_registration.leftCols<device::kLensParameters>() -= gain * device::lens_jacobian(known.lens, p);
    errors.by_registration.middleCols<3>(kLandmarksAt + 3 * static_cast<Eigen::Index>(seen.landmark)) -=
        gain * JL;
    errors.by_picture += gain * noise * gain.transpose();
  }
  return errors;
}

std::vector<OverlaySpot> spots_of(const rig::SurfaceCalibration& surface) {
  std::vector<OverlaySpot> spots;
  const Matrix3 R = surface.X_world_rectangle.matrix();
  for (int i = 0; i < kAlong; ++i)
    for (int j = 0; j < kAcross; ++j) {
      const double u = (i + 0.5) / kAlong, v = (j + 0.5) / kAcross;
      const Vector3 arm = R * Vector3(u * surface.width, v * surface.height, 0.0);
      OverlaySpot spot{surface.X_world_rectangle.translation + arm, Matrix3::Zero()};
      if (surface.covariance.rows() == 8) {
        Eigen::Matrix<double, 3, 8> J;
        J << -hat(arm), Matrix3::Identity(), u * R.col(0), v * R.col(1);
        spot.covariance = J * surface.covariance * J.transpose();
      }
      spots.push_back(spot);
    }
  return spots;
}

}  // namespace

double OverlayParts::total() const {
  return std::sqrt(picture * picture + registration * registration + surfaces * surfaces);
}

std::vector<Matrix3> shape_covariances(const std::vector<rig::Landmark>& landmarks,
                                       const Eigen::MatrixXd& registration) {
  const auto count = static_cast<Eigen::Index>(landmarks.size());
  if (count == 0) return {};
  // Of the places where the lens is given: Schur complement.
  const Eigen::MatrixXd with_lens = registration.block(kLandmarksAt, 0, 3 * count, device::kLensParameters);
  const Eigen::MatrixXd lens_information = covariance_from_information(
      registration.topLeftCorner<device::kLensParameters, device::kLensParameters>());
  Eigen::MatrixXd C = registration.bottomRightCorner(3 * count, 3 * count) -
                      with_lens * lens_information * with_lens.transpose();
  // C = G M G' + rest, with the largest M that leaves a covariance as rest: (G' C^-1 G)^-1.
  if (count >= 3) {
    Vector3 mean = Vector3::Zero();
    for (const auto& landmark : landmarks) mean += landmark.place.m / static_cast<double>(count);
    Eigen::MatrixXd G(3 * count, 6);  // d place / d (turn about their mean, shift) of all together
    for (Eigen::Index i = 0; i < count; ++i)
      G.middleRows<3>(3 * i) << -hat(landmarks[static_cast<std::size_t>(i)].place.m - mean),
          Matrix3::Identity();
    const Eigen::MatrixXd information = covariance_from_information(C);
    C -= G * covariance_from_information(G.transpose() * information * G) * G.transpose();
  }
  std::vector<Matrix3> shapes;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto [values, axes] =
        symmetric_eigen(C.block<3, 3>(3 * i, 3 * i));  // rounding may leave it below 0
    shapes.emplace_back(axes * values.cwiseMax(0.0).asDiagonal() * axes.transpose());
  }
  return shapes;
}

OverlayKnowledge overlay_knowledge(const rig::Rig& rig) {
  OverlayKnowledge known;
  if (rig.camera) known.lens = rig.camera->model;
  if (rig.hand_eye) known.R_marker_camera = rig.hand_eye->X_marker_camera.rotation;
  known.registration = rig::registration_covariance(rig);
  known.landmarks = rig.landmarks;
  const auto shapes = shape_covariances(rig.landmarks, known.registration);
  for (std::size_t i = 0; i < shapes.size(); ++i) known.landmarks[i].covariance = shapes[i];
  for (const auto& surface : rig.surfaces)
    for (const auto& spot : spots_of(surface)) known.spots.push_back(spot);
  return known;
}

std::optional<OverlayParts> expected_overlay(const OverlayKnowledge& known, const OverlayPicture& picture) {
  const Pose<World, CameraOptical>& X_world_camera = picture.pose.X_world_camera;
  const PoseErrorSources pose = pose_error_sources(known, picture);
  const Pose<CameraOptical, World> X = X_world_camera.inverse();
  double by_picture = 0.0, by_surfaces = 0.0;
  // sum trace(M C M') over the spots is trace(C sum M'M).
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(known.registration.rows(), known.registration.cols());
  int count = 0;
  for (const OverlaySpot& spot : known.spots) {
    const Vector3 p = (X * Point<World>{spot.place}).m;
    if (p.z() < kLeastDepth) continue;
    Eigen::Matrix<double, 2, 3> Jd;  // through the lens
    const device::Pixel seen = device::project(known.lens, p, Jd);
    if (seen.x() < 0 || seen.y() < 0 || seen.x() > known.lens.width - 1 || seen.y() > known.lens.height - 1)
      continue;
    // A ray far outside may fold back into the picture; where the lens can be undone it comes back to itself.
    const auto back = known.lens.undistort_pixel(seen);
    if (!back || (*back - known.lens.project_undistorted(p)).norm() > 0.01) continue;
    ++count;
    const Eigen::Matrix<double, 2, 3> Jp = device::projection_jacobian(known.lens, p);
    const Eigen::Matrix<double, 2, 6> JX = Jp * point_in_camera(X_world_camera, spot.place);
    by_picture += (JX * pose.by_picture * JX.transpose()).trace();
    const Eigen::Matrix<double, 2, 3> JW = Jp * X_world_camera.matrix().transpose();
    by_surfaces += (JW * spot.covariance * JW.transpose()).trace();
    Eigen::MatrixXd M = JX * pose.by_registration;
    // The real spot is seen through the true lens and undone by the known one.
    const Eigen::Matrix2d undo = Jp.leftCols<2>() * Jd.leftCols<2>().inverse();
    M.leftCols<device::kLensParameters>() += undo * device::lens_jacobian(known.lens, p);
    squares.noalias() += M.transpose() * M;
  }
  if (count == 0) return std::nullopt;
  OverlayParts parts;
  parts.picture = std::sqrt(by_picture / count);
  parts.registration = std::sqrt(std::max(0.0, squares.cwiseProduct(known.registration).sum()) / count);
  parts.surfaces = std::sqrt(by_surfaces / count);
  return parts;
}

}  // namespace palpate::vision
