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

Eigen::MatrixXd rig_covariance(const Estimate<ArmSolution>& estimate) {
  const std::vector<std::string> order = rig::covariance_order(estimate.value.model);
  const auto& names = estimate.value.parameters;
  const auto n = static_cast<Eigen::Index>(order.size());
  std::vector<Eigen::Index> place;
  for (const auto& name : order) {
    const auto at = std::find(names.begin(), names.end(), name) - names.begin();
    place.push_back(at < estimate.covariance.rows() ? at : -1);
  }
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto a = place[static_cast<std::size_t>(i)], b = place[static_cast<std::size_t>(j)];
      if (a >= 0 && b >= 0) covariance(i, j) = estimate.covariance(a, b);
    }
  return covariance;
}

rig::ArmCalibration rig_arm(const Estimate<ArmSolution>& estimate) {
  rig::ArmCalibration arm;
  const auto& s = estimate.value;
  arm.model = s.model;
  arm.correction = {s.gain, s.offset};
  arm.X_world_base = s.X_world_base;
  arm.tip_in_marker = s.tip_in_marker;
  arm.covariance = rig_covariance(estimate);
  return arm;
}

}  // namespace palpate::calibration::session
