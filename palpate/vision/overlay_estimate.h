// How far, in pixels of the drawn picture, virtual things stand from the real ones: as the system itself
// knows it, without any truth.
//
// Asked at spots spread over the calibrated surfaces. Three independent kinds of error meet there, each
// carried to the pixel by first derivatives:
//   of the picture    its landmarks' detection and the tracker's noise, another in every frame
//   of registration   lens, hand-eye and landmarks' places (registration_covariance): the same in all frames.
//                     They reach the spot by the drawing and by the pose that they make of the picture, and
//                     cancel in part: a lens that is wrong moved the landmarks to where it shows them
//   of the surfaces   the spot's own place in World (SurfaceCalibration::covariance)
// The result is an rms over the spots in view: the root of the mean of E|error|^2 over many laboratories that
// are calibrated like this one. One laboratory's registration and surfaces are wrong in one way for good, so
// its own figure scatters about this one. World frame, SI; pixels of CameraModel. Pure functions, any thread;
// some 0.2 ms. Source: propagation as in Hartley & Zisserman (2004), section 5.2; what a solve takes for
// granted as considered parameters after Schmidt (1966).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "palpate/rig/rig.h"
#include "palpate/vision/pose_refinement.h"

namespace palpate::vision {

struct OverlaySpot {
  Vector3 place = Vector3::Zero();       // m, World, as calibrated
  Matrix3 covariance = Matrix3::Zero();  // m^2
};

struct OverlayKnowledge {
  device::CameraModel lens;
  Quaternion R_marker_camera = Quaternion::Identity();
  // For refine_camera_pose: their covariance is that of their shape, without what they have in common with
  // each other and with the lens. Common errors move the pose and leave nothing to disagree about, so in a
  // sighting's weight, or in the judgement whether it is false, they have no place.
  std::vector<rig::Landmark> landmarks;
  Eigen::MatrixXd registration;  // covariance: lens 9, hand-eye 6, landmarks 3 each
  std::vector<OverlaySpot> spots;
};

// 5 x 4 spots on each surface of the rig; they need a calibrated camera. Where the rig does not state a
// covariance its part counts as nothing.
OverlayKnowledge overlay_knowledge(const rig::Rig& rig);

// What is left of landmarks' covariances (m^2) where the lens is as it is and they, as one body, may lie
// anywhere: the part of `registration` that a picture of them can contradict.
std::vector<Matrix3> shape_covariances(const std::vector<rig::Landmark>& landmarks,
                                       const Eigen::MatrixXd& registration);

struct OverlayParts {  // px, rms over the spots in view
  double picture = 0.0, registration = 0.0, surfaces = 0.0;
  double total() const;
};

// A picture's pose as it was found: with known.landmarks, from a prior whose covariance is that of the
// hand-eye transform and `tracker`, the rest.
struct OverlayPicture {
  CameraPosePrior prior;
  Matrix6 tracker = Matrix6::Zero();
  RefinedPose pose;
  double pixel_sd = RefinementOptions{}.pixel_sd;  // as the refinement had it
};

// Nothing where no spot is in view.
std::optional<OverlayParts> expected_overlay(const OverlayKnowledge& known, const OverlayPicture& picture);

}  // namespace palpate::vision
