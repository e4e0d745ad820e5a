// The Cramer-Rao bound of the arm's calibration: how good any unbiased method can be on given samples.
//
// Model: R g(gain * psi + offset) + T = R_m t + p_m, with the marker's pose (R_m, p_m) measured with normal
// errors. Free: base turn 3 (left, World axes), base place 3, gains 3, offsets 2 and 3, tip in marker 3
// (where asked for); lengths known. Each sample tells J^T S^-1 J, S the covariance of its measured tip: that
// of the LEDs carried through the marker's fit. The first offset is held (it trades with the base's turn),
// which no error of a place depends on. SI. Pure functions. Source: Kay (1993), "Fundamentals of statistical
// signal processing: estimation theory", section 3.9; in the form for implicit models of Fuller (1987).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "palpate/device/phantom.h"
#include "palpate/math/pose.h"

namespace palpate::evaluation::studies {

struct TrueArm {
  device::PhantomLengths lengths;
  device::JointCorrection joints;
  Pose<World, ArmBase> X_world_base;
};

struct BoundSample {
  Vector3 psi = Vector3::Zero();  // encoder readings, rad
  Quaternion R_world_marker = Quaternion::Identity();
  Matrix3 covariance = Matrix3::Identity();  // of the measured tip, World, m^2
};

enum class TipIs { known, estimated };

// Columns of the derivatives: base turn 0-2, base place 3-5, gains 6-8, offsets 2 and 3 in 9 and 10, tip
// 11-13.
inline constexpr Eigen::Index kBoundGains = 6, kBoundOffsets = 9, kBoundTip = 11, kBoundSize = 14;

// d (predicted - measured tip) / d parameters.
Eigen::Matrix<double, 3, kBoundSize> tip_derivatives(const TrueArm& arm, const Vector3& psi,
                                                     const Quaternion& R_world_marker);

// Least covariance of the parameters, 11 x 11 with the tip known, 14 x 14 with it estimated. Infinite where
// the samples do not determine them.
Eigen::MatrixXd parameter_bound(const TrueArm& arm, const std::vector<BoundSample>& samples, TipIs tip);

// Least rms error of the predicted tip, m, over the places where the encoders read `psi`.
double workspace_bound(const TrueArm& arm, const Eigen::MatrixXd& parameter_covariance,
                       const std::vector<Vector3>& psi);

}  // namespace palpate::evaluation::studies
