// The kinematics of an arm as a value: a PHANToM with two lengths, or any serial arm by Denavit-Hartenberg
// rows.
//
// Frames: ArmBase; the tip is given in it. Joint angles theta in radians (corrected ones: gain * reading +
// offset), lengths in metres. Pure functions, safe from any thread. Errors of the reader: wrong use, with
// file and line. Source of the rows: Denavit, Hartenberg (1955), "A kinematic notation for lower-pair
// mechanisms", in the standard (distal) form: A_j = Rot_z(theta_j + theta_offset_j) Trans_z(d_j) Trans_x(a_j)
// Rot_x(alpha_j).
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/device/phantom.h"

namespace palpate::device {

struct JointRange {
  double low = -std::numeric_limits<double>::infinity();  // rad, corrected angle
  double high = std::numeric_limits<double>::infinity();
  bool known() const { return std::isfinite(low) && std::isfinite(high); }
};

struct DhJoint {
  double a = 0.0, alpha = 0.0, d = 0.0, theta_offset = 0.0;  // m, rad
  JointRange range{};
};

struct ArmModel {
  enum class Kind { phantom, dh };
  Kind kind = Kind::phantom;
  std::string name = "phantom-premium-1.5";
  PhantomLengths lengths;                         // phantom
  std::vector<DhJoint> joints;                    // dh
  Vector3 tool = Vector3::Zero();                 // dh: the tip in the last link's frame
  bool tool_known = false;                        // dh: else the tool point is estimated with the rest
  Quaternion tool_turn = Quaternion::Identity();  // dh: the stylus in that frame, its gimbal at zero

  Eigen::Index joint_count() const {
    return kind == Kind::phantom ? 3 : static_cast<Eigen::Index>(joints.size());
  }
};

// How the tip moves with everything it depends on; columns per joint. Only what the kind has is filled.
struct ArmJacobian {
  Eigen::Matrix3Xd theta;                                                     // m/rad
  Eigen::Matrix3Xd a, alpha, d;                                               // dh: -, m/rad, -
  Eigen::Matrix<double, 3, 2> lengths = Eigen::Matrix<double, 3, 2>::Zero();  // phantom: l1, l2
  Matrix3 tool = Matrix3::Zero();                                             // dh
};

Point<ArmBase> arm_tip(const ArmModel& model, const Eigen::VectorXd& theta);
Point<ArmBase> arm_tip(const ArmModel& model, const Eigen::VectorXd& theta, ArmJacobian& jacobian);

// "phantom-premium-1.5", or a TOML file: type = "dh" with one [[joint]] per joint (a_mm, alpha_deg, d_mm,
// theta_offset_deg, optional range_deg) and optional tool_mm and tool_qwxyz; or type = "phantom" with
// lengths_mm.
Expected<ArmModel> read_arm_model(const std::string& name_or_file);
Expected<ArmModel> parse_arm_model(std::string_view content, std::string source);  // such a file's content

}  // namespace palpate::device
