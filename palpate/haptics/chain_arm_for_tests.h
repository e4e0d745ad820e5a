// Arms for tests that are no PHANToM: chains of joints, with the motors that a test wants, and what their
// torques do to a hand, by finite differences of the chain's rows alone.
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "palpate/device/arm_kinematics.h"
#include "palpate/device/devices.h"
#include "palpate/rig/rig.h"

namespace palpate::haptics {

inline device::ArmModel three_joint_arm() {
  device::ArmModel model{.kind = device::ArmModel::Kind::dh, .name = "three"};
  model.joints = {{0.0, 1.5707963267948966, 0.1, 0.0}, {0.25, 0.0, 0.0, 0.2}, {0.22, 0.1, 0.01, -0.4}};
  return model;
}

inline device::ArmModel six_joint_arm() {
  auto model = device::read_arm_model(std::string(PALPATE_DATA_DIR) + "/ur5_laser_tracker/ur5.toml");
  if (!model) throw std::runtime_error(model.error().message);
  model->tool = {0.01, -0.02, 0.12};
  model->tool_turn = so3_exp(Vector3(0.3, -0.2, 0.5));
  return *model;
}

// A rig's arm of this kind, whose encoders are a little off.
inline rig::ArmCalibration chain_calibration(const device::ArmModel& model) {
  rig::ArmCalibration arm;
  arm.model = model;
  arm.correction = device::JointCorrection::none(model.joint_count());
  for (Eigen::Index j = 0; j < model.joint_count(); ++j) {
    arm.correction.gain[j] = 1.0 + 0.004 * static_cast<double>(j - 1);
    arm.correction.offset[j] = 0.01 * static_cast<double>(2 - j);
  }
  arm.X_world_base = {rotation_from_xyz({0.3, -0.2, 0.9}), {0.10, -1.40, 1.75}};
  arm.rest_readings = device::JointVector::filled(model.joint_count(), 0.0);
  return arm;
}

inline device::JointVector bent(const device::ArmModel& model) {
  return device::JointVector{0.4, -0.9, 1.3, -0.6, 0.8, 0.2}.head(model.joint_count());
}

// The tip in World, row by row; nothing of it is shared with what it judges.
inline Vector3 chain_tip(const rig::ArmCalibration& arm, const device::JointVector& psi) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  for (Eigen::Index j = 0; j < psi.size(); ++j) {
    const device::DhJoint& row = arm.model.joints[static_cast<std::size_t>(j)];
    const double theta = arm.correction.gain[j] * psi[j] + arm.correction.offset[j] + row.theta_offset;
    X = X * Eigen::AngleAxisd(theta, Vector3::UnitZ()) * Eigen::Translation3d(row.a, 0.0, row.d) *
        Eigen::AngleAxisd(row.alpha, Vector3::UnitX());
  }
  return arm.X_world_base.rotation * (X * arm.model.tool) + arm.X_world_base.translation;
}

// d tip / d theta in World: the motion of the true joints, whatever their encoders make of it.
inline Eigen::Matrix3Xd numeric_jacobian(const rig::ArmCalibration& arm, const device::JointVector& psi) {
  Eigen::Matrix3Xd J(3, psi.size());
  for (Eigen::Index j = 0; j < psi.size(); ++j) {
    constexpr double kH = 1e-6;
    device::JointVector up = psi, down = psi;
    up[j] += kH / arm.correction.gain[j];
    down[j] -= kH / arm.correction.gain[j];
    J.col(j) = (chain_tip(arm, up) - chain_tip(arm, down)) / (2.0 * kH);
  }
  return J;
}

// A chain on a bench. Its motors take torques, or, where it has none, it takes forces.
class ChainArm : public device::ArmDevice, private device::JointMotors {
 public:
  ChainArm(const device::JointVector& psi, bool takes_torques) : takes_torques_(takes_torques) {
    sample.joints = psi;
    most = device::JointVector::filled(psi.size(), 100.0);
    let_go();
  }
  device::ArmSample read() override {
    sample.stamp += Duration(1'000'000);
    return sample;
  }
  device::JointMotors* motors() override { return takes_torques_ ? this : nullptr; }
  void command(const Vector3& f) override {
    force = f;
    asked_wrongly = asked_wrongly || takes_torques_;
  }
  void let_go() noexcept override {
    force.setZero();
    torques.setZero(sample.joints.size());
  }

  device::ArmSample sample;
  device::JointVector torques, most;
  Vector3 force = Vector3::Zero();
  double largest_share = 0.0;  // of a motor's limit, of all commands so far
  bool asked_wrongly = false;

 private:
  void command(const device::JointVector& asked) override {
    torques = asked;
    asked_wrongly = asked_wrongly || !takes_torques_ || asked.size() != most.size() || !asked.allFinite();
    largest_share = std::max(largest_share, asked.cwiseQuotient(most).cwiseAbs().maxCoeff());
  }
  device::JointVector limits() const override { return most; }

  bool takes_torques_;
};

}  // namespace palpate::haptics
