// What an arm's joints do to its tip, for whoever moves it or pushes with it: the haptic tick, a driver.
//
// Frames: ArmBase and Tip. Joint angles theta are corrected ones, rad; m. Objects do not change and are safe
// from any thread; their functions do not allocate, lock or throw where the number of angles is
// joint_count(), which the caller sees to. A model of a new kind is one more class here and its line in
// make_kinematics().
#pragma once

#include <memory>

#include "palpate/device/arm_model.h"
#include "palpate/device/joints.h"
#include "palpate/math/pose.h"

namespace palpate::device {

// d tip / d theta, metres per radian, a column per joint. Transposed it turns a force at the tip into torques.
using TipJacobian = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMostJoints>;

struct PoseAndJacobian {
  Pose<ArmBase, Tip> pose;
  TipJacobian jacobian;
};

class ArmKinematics {
 public:
  virtual ~ArmKinematics() = default;
  virtual int joint_count() const = 0;  // 3 ... kMostJoints
  // The stylus: the tip's place and, with the gimbal's angles (rad, zeros where it has none), its axes.
  virtual Pose<ArmBase, Tip> pose(const JointVector& theta, const Vector3& gimbal) const = 0;
  virtual TipJacobian jacobian(const JointVector& theta) const = 0;
  // Both in one walk along the arm, for whoever needs both in a tick; the same numbers.
  virtual PoseAndJacobian pose_and_jacobian(const JointVector& theta, const Vector3& gimbal) const = 0;
  // Corrected angles that a joint reaches; not known() where nobody has told.
  virtual JointRange range(int joint) const = 0;
  // m^3. Where manipulability() is no larger, the arm counts as folded or stretched: in some direction its
  // motors have hardly any force.
  // Of a Cartesian arm without a unit.
  virtual double least_manipulability() const = 0;
};

// The stylus' turn by its gimbal's angles: about y, then x, then z; and the angles of a turn.
Quaternion gimbal_turn(const Vector3& gimbal);
Vector3 gimbal_angles(const Quaternion& turn);

// sqrt(det(J J^T)), the volume of the tip's motions for joint motions of norm 1 (Yoshikawa 1985,
// "Manipulability of robotic mechanisms"); of three joints |det J|.
double manipulability(const TipJacobian& J);

// Throws std::invalid_argument for a chain of fewer than 3 or more than kMostJoints joints.
std::unique_ptr<const ArmKinematics> make_kinematics(const ArmModel& model);

// Wrong use, in words: why make_kinematics() would throw.
Expected<void> check_runnable(const ArmModel& model);

}  // namespace palpate::device
