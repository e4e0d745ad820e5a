// The camera's pose made exact by the picture itself: seen landmarks pull the pose that tracker and hand-eye
// give.
//
// Minimises, by least squares on rotation and translation, sum_i rho(r_i' S_i^-1 r_i) + e' P^-1 e, with r_i =
// project(X^-1 L_i) - u_i in pixels of the camera's own (distorted) image, S_i = pixel variance + the
// landmark's covariance seen in the image, e the deviation from the prior pose, P the prior's covariance, and
// rho Huber's loss. The lens is applied to the landmark, never undone on the pixel: detection noise is even
// in the distorted image. Metres, pixels, radians; covariances: rotation (rad, axes of the left frame, left
// perturbation R = exp(w) R0) then translation (m). Pure functions, any thread; a few microseconds. Source:
// Lepetit & Fua (2005), "Monocular model-based 3D tracking of rigid objects", chapters 2 and 5.
#pragma once

#include <vector>

#include "palpate/device/camera_model.h"
#include "palpate/rig/rig.h"

namespace palpate::vision {

struct CameraPosePrior {
  Pose<World, CameraOptical> X_world_camera;
  Matrix6 covariance = Matrix6::Zero();
};

// What tracker and hand-eye together say about the camera, with both uncertainties.
CameraPosePrior camera_from_marker(const Pose<World, CameraMarker>& X_world_marker,
                                   const Matrix6& marker_covariance, const rig::HandEyeCalibration& hand_eye);

struct Sighting {
  std::size_t landmark = 0;                      // index into the landmarks
  device::Pixel centre = device::Pixel::Zero();  // in the camera's image, distorted
  // px^2, as the detector states it; the options' pixel_sd comes on top. Zero: pixel_sd alone.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};

// px per axis: what a sighting that states its covariance is off beyond it (a lens that is no polynomial,
// light that is no even disc).
inline constexpr double kUnstatedSightingSd = 0.03;

struct RefinementOptions {
  double pixel_sd = 0.1;  // of a detected centre, px per axis
  double huber = 2.0;     // whitened length from which a sighting pulls with constant force
  double reject = 4.0;    // whitened length beyond which a sighting is no inlier (3e-4 of honest ones)
  int least_inliers = 3;  // fewer, and the prior stays as it is
  // Of the sightings, at least this share must be inliers: where more disagree, nobody can say which lie.
  double least_share = 0.5;
  int max_iterations = 10;
};

struct RefinedPose {
  Pose<World, CameraOptical> X_world_camera;
  Matrix6 covariance = Matrix6::Zero();
  bool refined = false;  // false: this is the prior
  int inliers = 0, outliers = 0;
  double rms_px = 0.0;  // of the inliers, sqrt(sum |r|^2 / n)
  double misfit = 0.0;  // whitened rms of the inliers per axis: about 1 where what is stated is true
  int iterations = 0;
  std::vector<Sighting> used;  // the inliers
};

RefinedPose refine_camera_pose(const device::CameraModel& camera, const CameraPosePrior& prior,
                               const std::vector<rig::Landmark>& landmarks,
                               const std::vector<Sighting>& sightings, const RefinementOptions& options = {});

}  // namespace palpate::vision
