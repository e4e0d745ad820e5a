// The numbers of a rig that a verification predicts by, and how errors of the calibration and changes move them.
//
// Errors are a vector in the order of RigLayout: the arm's as rig::covariance_order has them, the pointer's tip 3
// (m), each surface 8 (as SurfaceCalibration::covariance), registration (lens 9, hand-eye 6, landmarks 3 each),
// the camera's delay and the tracker's (s), the tracker's systematic error where the head is (rad, m). Internal to
// this module. Pure functions, no thread rule.
#pragma once

#include <vector>

#include "palpate/calibration/verification.h"

namespace palpate::calibration {

struct RigState {
  device::ArmModel model;
  Eigen::VectorXd gain, offset, zero;  // theta = gain psi + offset + zero
  Pose<World, ArmBase> X_world_base;
  Vector3 tip = Vector3::Zero(), pointer_tip = Vector3::Zero();
  std::vector<rig::SurfaceCalibration> surfaces;  // places and sides
  device::CameraModel lens;
  Pose<CameraMarker, CameraOptical> X_marker_camera;
  std::vector<Vector3> landmarks;
  double camera_delay = 0.0, tracker_delay = 0.0;  // s, beside the rig's
  Vector6 head_field = Vector6::Zero();            // of the camera's marker: rotation, shift

  Point<World> tip_at(const Eigen::VectorXd& psi) const;
  Point<World> place(const TouchedPlace& touched) const;
  // Of a landmark in a frame's picture; none where it lies behind the camera.
  std::optional<device::Pixel> pixel(const HeadFrame& frame, const Vector3& point) const;
};

RigState state_of(const rig::Rig& rig);

// Lower-rank root R of the errors' covariance: errors = R u, u independent, of variance 1.
Eigen::MatrixXd error_root(const rig::Rig& rig, const VerificationOptions& options);
RigState with_errors(const RigState& at, const Eigen::VectorXd& errors);

// How a change is told in numbers, and how large one usually is (prior deviation of each).
Eigen::VectorXd change_sizes(Change change, const RigState& state);
RigState with_change(const RigState& at, Change change, const Eigen::VectorXd& amount);

}  // namespace palpate::calibration
