// Landmarks on a table's edge and a wall, a head that looks at them, and a noisy tracker: for tests only.
#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "palpate/math/linear_algebra.h"
#include "palpate/math/random_vector.h"
#include "palpate/vision/pose_refinement.h"

namespace palpate::vision::synthetic {

inline device::CameraModel lens() {
  device::CameraModel camera;
  camera.fx = 560.0, camera.fy = 561.5, camera.cx = 318.7, camera.cy = 242.1;
  camera.distortion = {-0.28, 0.09, 0.001, -0.0005, 0.0};
  return camera;
}

inline Vector6 draw(const Matrix6& covariance, Random& random) {
  Vector6 n;
  for (int i = 0; i < 6; ++i) n(i) = random.normal();
  return covariance.llt().matrixL() * n;
}

template <typename A, typename B>
Pose<A, B> disturbed(const Pose<A, B>& X, const Vector6& d) {
  return {so3_exp(d.head<3>()) * X.rotation, X.translation + d.tail<3>()};
}

inline Eigen::VectorXd draw(const Eigen::MatrixXd& covariance, Random& random) {
  const auto [values, axes] = symmetric_eigen(covariance);
  Eigen::VectorXd n(values.size());
  for (Eigen::Index i = 0; i < n.size(); ++i) n[i] = std::sqrt(std::max(values[i], 0.0)) * random.normal();
  return axes * n;
}

// Of a lens calibrated from a dozen views of a board that fills the middle of the picture, corners found to
// 0.05 px: focal lengths hang together, and so do k1, k2 and k3.
inline Eigen::MatrixXd board_lens_covariance() {
  constexpr Eigen::Index kBrown = 9;  // of device::kLensParameters
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(kBrown, kBrown);
  const device::CameraModel camera = lens();
  for (int view = 0; view < 12; ++view) {
    Matrix6 A = Matrix6::Zero();
    Eigen::Matrix<double, kBrown, 6> B = Eigen::Matrix<double, kBrown, 6>::Zero();
    const Matrix3 R = so3_exp(0.5 * Vector3(std::sin(1.7 * view), std::cos(2.3 * view), 0.3 * std::sin(view)))
                          .toRotationMatrix();
    const Vector3 middle(0.12 * std::sin(0.9 * view), 0.08 * std::cos(1.3 * view),
                         0.75 + 0.1 * std::sin(view));
    for (int i = 0; i < 9; ++i)
      for (int j = 0; j < 6; ++j) {
        const Vector3 turned = R * Vector3(0.025 * (i - 4), 0.025 * (j - 2.5), 0.0), p = turned + middle;
        Eigen::Matrix<double, 2, 3> J;
        device::project(camera, p, J);
        Eigen::Matrix<double, 2, 6> Jp;
        Jp << -J * hat(turned), J;
        const Eigen::Matrix<double, 2, kBrown> Jl = device::lens_jacobian(camera, p).leftCols<kBrown>();
        A += Jp.transpose() * Jp, B += Jl.transpose() * Jp, information += Jl.transpose() * Jl;
      }
    information -= B * solve_symmetric_columns(A, B.transpose());
  }
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(device::kLensParameters, device::kLensParameters);
  covariance.topLeftCorner<kBrown, kBrown>() = 0.05 * 0.05 * covariance_from_information(information);
  return covariance;
}

// Deviation of `truth` from `estimate` in the convention of the covariances.
template <typename A, typename B>
Vector6 error(const Pose<A, B>& truth, const Pose<A, B>& estimate) {
  Vector6 e;
  e << so3_log(truth.rotation * estimate.rotation.conjugate()), truth.translation - estimate.translation;
  return e;
}

inline Matrix6 diagonal(double turn, double shift) {
  Matrix6 C = Matrix6::Zero();
  C.diagonal() << turn * turn, turn * turn, turn * turn, shift * shift, shift * shift, shift * shift;
  return C;
}

// Twelve dots: six along the table's far and side edges, six on the wall behind it.
inline std::vector<rig::Landmark> dots() {
  std::vector<rig::Landmark> result;
  for (int i = 0; i < 6; ++i) {
    rig::Landmark table, wall;
    table.place.m = Vector3(-0.35 + 0.14 * i, -1.52, i % 2 == 0 ? 1.6 : 0.95);
    wall.place.m = Vector3(-0.35 + 0.14 * i, i % 2 == 0 ? -1.4 : -1.0, 0.8);
    wall.normal = Vector3::UnitZ();
    result.push_back(table), result.push_back(wall);
  }
  return result;
}

inline rig::HandEyeCalibration hand_eye() {
  rig::HandEyeCalibration h;
  h.X_marker_camera = {so3_exp(Vector3(0.07, -0.05, 3.1)), Vector3(0.012, -0.065, 0.034)};
  return h;
}

// The camera at the head's place, looking at the table's middle, turned a little at time t.
inline Pose<World, CameraOptical> camera_pose(double t) {
  const Vector3 eye(0.05 * std::sin(0.9 * t), -0.95 + 0.03 * std::sin(0.7 * t),
                    2.3 + 0.05 * std::cos(0.5 * t));
  const Vector3 z = (Vector3(0, -1.4, 1.2) - eye).normalized(),
                x = Vector3::UnitY().cross(z).normalized() * -1.0;
  Matrix3 R;
  R << x, z.cross(x), z;
  return {
      Quaternion(R) * so3_exp(Vector3(0.12 * std::sin(1.3 * t), 0.15 * std::sin(t), 0.1 * std::sin(1.7 * t))),
      eye};
}

inline std::vector<Sighting> sightings(const device::CameraModel& camera, const Pose<World, CameraOptical>& X,
                                       const std::vector<rig::Landmark>& landmarks, double noise_px,
                                       Random& random) {
  std::vector<Sighting> result;
  const auto inverse = X.inverse();
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const Vector3 p = (inverse * landmarks[i].place).m;
    if (p.z() < 0.1) continue;
    const device::Pixel u = camera.project(p);
    if (u.x() < 4 || u.y() < 4 || u.x() > camera.width - 5 || u.y() > camera.height - 5) continue;
    result.push_back({i, u + device::Pixel(random.normal(noise_px), random.normal(noise_px))});
  }
  return result;
}

}  // namespace palpate::vision::synthetic
