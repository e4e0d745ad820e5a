// Kinematics of a PHANToM-class arm: three actuated joints on a parallelogram, a three-joint gimbal at the
// tip.
//
// Frames: ArmBase (origin = tip at reset, theta = 0) and Tip. Joint angles theta in radians, lengths in
// metres. Pure functions, safe from any thread. Source: Cavusoglu, Feygin, Tendick (2002), "A critical study
// of the mechanical and electrical properties of the PHANToM haptic interface", equation 1. The 2006 paper
// prints its z row with sin(theta2) in the last place; as in the x row it must be sin(theta3):
//   x = sin t1 (l1 cos t2 + l2 sin t3)
//   y = l2 - l2 cos t3 + l1 sin t2
//   z = -l1 + cos t1 (l1 cos t2 + l2 sin t3)
// The gimbal (theta4..6, ours to define) turns the stylus, on the forearm's orientation, about y, then x,
// then z:
//   R_base_tip = Ry(t1) Rx(-t3) Ry(t4) Rx(t5) Rz(t6)
// so that at reset the stylus axes are the base's. The tip lies at the gimbal's centre: its place does not
// depend on the gimbal.
#pragma once

#include "palpate/device/joints.h"
#include "palpate/math/pose.h"

namespace palpate::device {

struct PhantomLengths {
  double l1 = 0.20955;  // m, makers' value for the Premium 1.5
  double l2 = 0.20955;
};

struct PhantomTip {
  Point<ArmBase> place;
  Matrix3 jacobian;  // d place / d theta, metres per radian
};
// Both at once: they have sines and cosines in common.
PhantomTip phantom_tip_and_jacobian(const Vector3& theta, const PhantomLengths& lengths = {});

Point<ArmBase> phantom_tip(const Vector3& theta, const PhantomLengths& lengths = {});
Matrix3 phantom_jacobian(const Vector3& theta, const PhantomLengths& lengths = {});

Quaternion phantom_stylus(const Vector3& theta, const Vector3& gimbal);

// Gimbal angles that give the stylus this orientation (|t5| <= pi/2).
Vector3 phantom_gimbal(const Vector3& theta, const Quaternion& R_base_tip);

inline Pose<ArmBase, Tip> phantom_pose(const Vector3& theta, const Vector3& gimbal,
                                       const PhantomLengths& lengths = {}) {
  return {phantom_stylus(theta, gimbal), phantom_tip(theta, lengths).m};
}

// Joint angles that put the tip there, elbow as in normal use. False where the point is out of reach.
bool phantom_inverse(const Point<ArmBase>& tip, const PhantomLengths& lengths, Vector3& theta);

}  // namespace palpate::device
