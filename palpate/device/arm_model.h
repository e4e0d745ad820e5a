// The kinematics of an arm as a value: a PHANToM with two lengths, any serial arm by Denavit-Hartenberg rows,
// or a Cartesian arm, which tells its tip's place itself (delta arms, point devices).
//
// Frames: ArmBase; the tip is given in it. Joint angles theta in radians (corrected ones: gain * reading +
// offset), lengths in metres. A Cartesian arm's three "angles" are the place it states, m: what follows for
// joints (readings, ranges, torques) is then for the axes of ArmBase, in m and N. Pure functions, safe from any thread. Errors of the reader: wrong use, with
// file and line. Source of the rows: Denavit, Hartenberg (1955), "A kinematic notation for lower-pair
// mechanisms", in the standard (distal) form: A_j = Rot_z(theta_j + theta_offset_j) Trans_z(d_j) Trans_x(a_j)
// Rot_x(alpha_j).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/device/phantom.h"
#include "palpate/device/place_correction.h"

namespace palpate::device {

struct JointRange {
  double low = -std::numeric_limits<double>::infinity();  // rad, corrected angle; m of a Cartesian arm
  double high = std::numeric_limits<double>::infinity();
  bool known() const { return std::isfinite(low) && std::isfinite(high); }
};

struct DhJoint {
  double a = 0.0, alpha = 0.0, d = 0.0, theta_offset = 0.0;  // m, rad
  JointRange range{};
};

struct ArmModel {
  enum class Kind { phantom, dh, cartesian };
  Kind kind = Kind::phantom;
  std::string name = "phantom-premium-1.5";
  PhantomLengths lengths;                         // phantom
  std::vector<DhJoint> joints;                    // dh
  Vector3 tool = Vector3::Zero();                 // dh: the tip in the last link's frame
  bool tool_known = false;                        // dh: else the tool point is estimated with the rest
  Quaternion tool_turn = Quaternion::Identity();  // dh: the stylus in that frame, its gimbal at zero
  std::array<JointRange, 3> places;               // cartesian: what it reaches along x, y, z
  PlaceCorrection correction;                     // cartesian

  Eigen::Index joint_count() const { return kind == Kind::dh ? static_cast<Eigen::Index>(joints.size()) : 3; }
};

// How people read an arm's readings: degrees of its joints, or millimetres of the place a Cartesian arm states.
struct ReadingUnit {
  const char* name;
  double per_si;  // so many of it are a radian, or a metre
};
ReadingUnit reading_unit(const ArmModel& model);

// How the tip moves with everything it depends on; columns per joint. Only what the kind has is filled.
struct ArmJacobian {
  Eigen::Matrix3Xd theta;                                                     // m/rad
  Eigen::Matrix3Xd a, alpha, d;                                               // dh: -, m/rad, -
  Eigen::Matrix<double, 3, 2> lengths = Eigen::Matrix<double, 3, 2>::Zero();  // phantom: l1, l2
  Matrix3 tool = Matrix3::Zero();                                             // dh
  PlaceCorrection::Basis correction = PlaceCorrection::Basis::Zero();         // cartesian
};

Point<ArmBase> arm_tip(const ArmModel& model, const Eigen::VectorXd& theta);
Point<ArmBase> arm_tip(const ArmModel& model, const Eigen::VectorXd& theta, ArmJacobian& jacobian);

// The arm that states its place of the simulated laboratory (palpate/sim/delta_arm.h), as its maker has it.
inline constexpr std::string_view kLaboratoryDelta = "laboratory-delta";
ArmModel laboratory_delta();

// "phantom-premium-1.5", "laboratory-delta", or a TOML file: type = "dh" with one [[joint]] per joint (a_mm, alpha_deg, d_mm,
// theta_offset_deg, optional range_deg) and optional tool_mm and tool_qwxyz; type = "phantom" with
// lengths_mm; or type = "cartesian" with range_mm, lowest and highest along x, y and z.
Expected<ArmModel> read_arm_model(const std::string& name_or_file);
Expected<ArmModel> parse_arm_model(std::string_view content, std::string source);  // such a file's content

}  // namespace palpate::device
