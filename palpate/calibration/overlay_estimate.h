// How far, in pixels of the drawn picture, virtual things stand from the real ones: as the system itself
// knows it, without any truth.
//
// Asked at spots spread over the calibrated surfaces. Four independent uncertainties meet there, each carried
// to the pixel by first derivatives:
//   the camera's pose in the landmarks' frame    (detection noise, landmarks' shape, tracker; RefinedPose)
//   the landmarks' common motion in World        (Rig::landmarks_shared)
//   the surface's own place in World             (SurfaceCalibration::covariance)
//   the lens                                     (CameraCalibration::covariance): what it moves at a spot,
//   and
//                                                what it makes the landmarks do to the pose
// The result is an rms over the spots in view: the root of the mean of E|error|^2, the mean of what many
// laboratories like this one would see. One laboratory's surfaces and lens are wrong in one way for good, so
// its own figure scatters about this one. World frame, SI; pixels of CameraModel. Pure functions, any thread;
// some 0.1 ms. Source: propagation as in Hartley & Zisserman (2004), section 5.2; the lens as a considered
// parameter after Schmidt (1966).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "palpate/calibration/pose_refinement.h"
#include "palpate/model/rig.h"

namespace palpate {

struct OverlaySpot {
  Vector3 place = Vector3::Zero();       // m, World, as calibrated
  Matrix3 covariance = Matrix3::Zero();  // m^2
};

struct OverlayKnowledge {
  CameraModel lens;
  Eigen::MatrixXd lens_root;  // 9 x k, root of the lens's covariance; empty where that is unknown
  std::vector<Landmark> landmarks;
  Vector3 landmarks_mean = Vector3::Zero();
  Matrix6 landmarks_shared = Matrix6::Zero();
  std::vector<OverlaySpot> spots;
};

// 5 x 4 spots on each surface of the rig; they need a calibrated camera. Where the rig does not state a
// covariance its part counts as nothing.
OverlayKnowledge overlay_knowledge(const Rig& rig);

struct OverlayParts {  // px, rms over the spots in view
  double pose = 0.0, landmarks = 0.0, surfaces = 0.0, lens = 0.0;
  double total() const;
};

// Of a picture drawn with `pose`; `pixel_sd` as the refinement had it. Nothing where no spot is in view.
std::optional<OverlayParts> expected_overlay(const OverlayKnowledge& known, const RefinedPose& pose,
                                             double pixel_sd = RefinementOptions{}.pixel_sd);

}  // namespace palpate
