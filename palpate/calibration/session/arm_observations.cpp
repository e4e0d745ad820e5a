#include "palpate/calibration/session/arm_observations.h"

#include <algorithm>
#include <cmath>

namespace palpate::calibration::session {

std::vector<device::ArmObservation> arm_observations(const std::vector<TrackedPose>& poses,
                                                     const Vector3& tip) {
  std::vector<device::ArmObservation> result;
  for (const auto& pose : poses) {
    device::ArmObservation sample;
    sample.joints = pose.joints;
    sample.gimbal = pose.gimbal;
    sample.time_s = pose.time_s;
    sample.marker = Pose<World, TipMarker>{pose.marker.rotation, pose.marker.translation};
    sample.covariance = pose.marker.point_covariance(tip);
    sample.systematic = std::sqrt(pose.marker.systematic.trace());
    result.push_back(sample);
  }
  return result;
}

rig::ArmCalibration rig_arm(const Estimate<ArmSolution>& estimate) {
  rig::ArmCalibration arm;
  const auto& s = estimate.value;
  arm.model.lengths = s.model.lengths;
  arm.correction.gain = s.gain.head<3>();
  arm.correction.offset = s.offset.head<3>();
  arm.X_world_base = s.X_world_base;
  arm.tip_in_marker = s.tip_in_marker;
  const std::vector<std::string> order = rig::covariance_order(arm.model);
  const auto size = static_cast<Eigen::Index>(order.size());
  arm.covariance = Eigen::MatrixXd::Zero(size, size);
  std::vector<Eigen::Index> place(order.size(), -1);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto at = std::find(s.parameters.begin(), s.parameters.end(), order[i]);
    if (at != s.parameters.end()) place[i] = at - s.parameters.begin();
  }
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t j = 0; j < order.size(); ++j)
      if (place[i] >= 0 && place[j] >= 0 && estimate.covariance.rows() > std::max(place[i], place[j]))
        arm.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            estimate.covariance(place[i], place[j]);
  return arm;
}

}  // namespace palpate::calibration::session
