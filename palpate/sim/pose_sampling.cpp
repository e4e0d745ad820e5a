#include "palpate/sim/pose_sampling.h"

#include <cmath>

#include "palpate/sim/simulated_arm.h"

namespace palpate::sim {
namespace {

constexpr double kAlongStylus = 0.85, kDownwards = 0.5;  // how the pull splits
constexpr int kAttempts = 10000;

}  // namespace

Vector3 middle_of_tracker(const config::WorldFile& world) {
  return (world.tracker.cameras[0] + world.tracker.cameras[1] + world.tracker.cameras[2]) / 3.0;
}

Vector3 middle_joints(const config::WorldFile& world) {
  Vector3 middle;
  for (int i = 0; i < 3; ++i) {
    const auto& [low, high] = world.arm.joint_range[static_cast<std::size_t>(i)];
    middle[i] = 0.5 * (low + high);
  }
  return middle;
}

std::optional<Vector3> random_joints(const config::WorldFile& world, Random& random) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Vector3 theta;
    for (int i = 0; i < 3; ++i) {
      const auto& [low, high] = world.arm.joint_range[static_cast<std::size_t>(i)];
      theta[i] = random.uniform(low, high);
    }
    if (theta[1] - theta[2] <= SimulatedArm::kFoldLimit) return theta;
  }
  return std::nullopt;
}

Quaternion facing(const Vector3& normal, const Vector3& towards) { return rotation_between(normal, towards); }

Quaternion random_orientation(const Vector3& normal, const Vector3& towards, double roll, Random& random) {
  const double cos_tilt = random.uniform(std::cos(kMarkerTilt), 1.0);
  const double around = random.uniform(0.0, 2.0 * std::numbers::pi);
  const Vector3 side = towards.unitOrthogonal();
  const Vector3 axis = std::cos(around) * side + std::sin(around) * towards.cross(side);
  const Quaternion tilt(Eigen::AngleAxisd(std::acos(cos_tilt), axis));
  const Quaternion rolled(Eigen::AngleAxisd(random.uniform(-roll, roll), towards));
  return (tilt * rolled * facing(normal, towards)).normalized();
}

Vector3 pull_direction(const Quaternion& R_world_stylus) {
  return (kAlongStylus * (R_world_stylus * Vector3::UnitZ()) - kDownwards * Vector3::UnitY()).normalized();
}

}  // namespace palpate::sim
