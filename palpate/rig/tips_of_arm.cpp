#include "palpate/rig/rig.h"

namespace palpate::rig {

std::vector<Point<World>> tips_of_arm(const ArmCalibration& arm) {
  constexpr double kTurn = 0.5, kWay = 0.1;  // rad, m: what a device's readings reach
  const int joints = arm.model.joint_count();
  const double step = arm.model.kind == device::ArmModel::Kind::cartesian ? kWay : kTurn;
  std::vector<Point<World>> tips;
  for (int moved = -1; moved < joints; ++moved) {
    auto readings = device::JointVector::filled(joints, 0.0);
    if (moved >= 0) readings[moved] = step;
    tips.push_back(arm.X_world_base * device::arm_tip(arm.model, arm.correction.apply(readings)));
  }
  return tips;
}

}  // namespace palpate::rig
