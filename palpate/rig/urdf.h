// A rig as a robot description (URDF) of ROS: the arm's kinematics as calibrated, camera, surfaces and bodies in World.
//
// Links: world, arm_base, one behind each joint, tip (the tip's place, axes of the stylus), tip_marker; camera_marker, which
// floats, with camera_optical (and right_camera_optical) on it; surfaces as thin plates, bodies as meshes. Joints joint_1 ...
// and gimbal_1 ... turn by corrected angles (gain * reading + offset, palpate/device/joints.h); a comment tells gains and
// offsets, which URDF has no place for. A PHANToM's parallelogram holds its forearm's angle against the base: a joint that
// mimics joint_2 backwards undoes the upper arm's turn. Metres, radians.
//
// Pure. Source: wiki.ros.org/urdf/XML; the arms: palpate/device/phantom.h, palpate/device/arm_model.h.
#pragma once

#include <string>

#include "palpate/rig/rig.h"

namespace palpate::rig {

// Needs rig.arm.
std::string urdf_of(const Rig& rig);

}  // namespace palpate::rig
