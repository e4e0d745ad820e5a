#include "palpate/calibration/pose_candidates.h"

#include <cmath>
#include <numbers>

namespace palpate::calibration {
namespace {

double end_or_between(Random& random, const std::array<double, 2>& range) {
  const bool end = random.chance(0.5);
  const double share = random.uniform();
  return end ? range[share < 0.5 ? 0 : 1] : range[0] + share * (range[1] - range[0]);
}

}  // namespace

std::vector<device::ArmObservation> candidate_poses(const ArmSolution& arm, const ReachablePoses& reach,
                                                    int count, Random& random,
                                                    const std::optional<Quaternion>& R_tip_marker,
                                                    const std::optional<PoseNoise>& noise) {
  std::vector<device::ArmObservation> poses;
  // A range that cannot be reached at all ends the search, not the program.
  for (int attempt = 0; attempt < 100 * count && static_cast<int>(poses.size()) < count; ++attempt) {
    device::ArmObservation pose;
    pose.joints.resize(3);
    for (Eigen::Index j = 0; j < 3; ++j)
      pose.joints[j] = end_or_between(random, reach.joint_range[static_cast<std::size_t>(j)]);
    const Vector3 theta = arm.gain.cwiseProduct(pose.joints) + arm.offset;
    const double cosine = std::cos(reach.largest_tilt);
    const double tilt = std::acos(random.chance(0.5) ? cosine : random.uniform(cosine, 1.0));
    const double around = random.uniform(-std::numbers::pi, std::numbers::pi),
                 roll = random.uniform(-std::numbers::pi, std::numbers::pi);
    if (theta[1] - theta[2] > reach.largest_fold) continue;

    const Point<World> tip = predict_tip(arm, pose.joints);
    const Vector3 towards = (reach.tracker - tip.m).normalized(), side = towards.unitOrthogonal();
    const Vector3 axis = std::cos(around) * side + std::sin(around) * towards.cross(side);
    const Quaternion R =
        (Quaternion(Eigen::AngleAxisd(tilt, axis)) * Quaternion(Eigen::AngleAxisd(roll, towards)) *
         rotation_between(reach.marker_normal, towards))
            .normalized();
    if (R_tip_marker) {
      const Vector3 gimbal = device::phantom_gimbal(
          theta, arm.X_world_base.rotation.conjugate() * R * R_tip_marker->conjugate());
      if (std::abs(gimbal[1]) > reach.largest_gimbal) continue;
    }
    pose.marker = Pose<World, TipMarker>{R, tip.m - R * arm.tip_in_marker};
    if (noise) {
      Eigen::Matrix<double, 3, 6> J;  // of the tip, by a turn and a shift of the marker
      J << -hat(R * arm.tip_in_marker), Matrix3::Identity();
      pose.covariance = J * noise->pose * J.transpose() + noise->systematic;
      pose.systematic = std::sqrt(noise->systematic.trace());
    }
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace palpate::calibration
