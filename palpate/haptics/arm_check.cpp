#include "palpate/haptics/arm_check.h"

namespace palpate::haptics {

Expected<void> check_arm(const rig::Rig& rig, device::OpenedArm& arm, const std::string& uri) {
  const device::ArmModel& model = rig.arm ? rig.arm->model : rig.nominal_arm;
  if (arm.facts().joints != model.joint_count())
    return refused(
        "arm {}: the device has {} joints, the rig's arm {} has {}; name the device that this rig was "
        "calibrated with, or calibrate this one (palpate calibrate arm)",
        uri, arm.facts().joints, model.name, model.joint_count());
  const bool cartesian = model.kind == device::ArmModel::Kind::cartesian;
  if (arm.facts().states_place != cartesian)
    return refused(
        "arm {}: the device states {}, the rig's arm {} is known by {}; name the device that this rig was "
        "calibrated with, or calibrate this one (palpate calibrate arm)",
        uri, arm.facts().states_place ? "its place" : "its joints", model.name,
        cartesian ? "its place" : "its joints");
  device::JointMotors* motors = arm.device().motors();
  if (motors == nullptr) return {};
  const device::JointVector limits = motors->limits();
  if (limits.size() != model.joint_count())
    return refused(
        "arm {}: its driver states limits of {} motors, the arm {} has {} joints; repair the driver", uri,
        limits.size(), model.name, model.joint_count());
  for (const double limit : limits)
    if (!(limit > 0.0 && std::isfinite(limit)))
      return refused(
          "arm {}: its driver states a motor's limit of {} N m, more than 0 is expected; repair the driver",
          uri, limit);
  return {};
}

}  // namespace palpate::haptics
