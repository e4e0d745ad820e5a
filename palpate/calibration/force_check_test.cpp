#include "palpate/calibration/force_check.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <map>
#include <numbers>

#include "palpate/core/random.h"
#include "palpate/device/phantom.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

// A hand drawn at random, and an arm with motors wired as told. Independent of the estimator: torques by the arm's
// Jacobian, a spring per pose.
struct Trial {
  Matrix3 axes = Matrix3::Identity();              // of the command, before it becomes torques
  Matrix3 motors = Matrix3::Identity();            // torques given over torques commanded
  double anisotropy = 0.35;                        // of the logarithm of the hand's stiffness, per component
  double change = 0.1, grip = 0.25, noise = 0.08;  // noise: of the response, per ramp and component
  double compliance = 1.0 / 250.0;
  std::vector<Vector3> angles = {
      {0.0, 0.2, 0.1}, {-0.5, 0.5, 0.1}, {0.5, 0.4, -0.2}, {-0.5, 0.0, -0.3}, {0.5, 0.1, 0.3}};

  static Matrix3 random_symmetric(Random& random, double sd) {
    Matrix3 E;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j) E(i, j) = E(j, i) = random.normal(i == j ? sd : sd / std::sqrt(2.0));
    return E;
  }
  static Matrix3 exponential(const Matrix3& E) {
    const auto eigen = symmetric_eigen(E);
    return eigen.vectors * Eigen::VectorXd(eigen.values.array().exp()).asDiagonal() *
           eigen.vectors.transpose();
  }

  std::vector<ForcePose> play(std::uint64_t seed) const {
    Random random(seed, "force check");
    const Matrix3 hand = random_symmetric(random, anisotropy);
    std::vector<ForcePose> poses;
    for (const auto& theta : angles) {
      const Matrix3 J = device::phantom_jacobian(theta);
      const double firm = random.normal(grip);
      const Matrix3 C =
          compliance * exponential(hand + random_symmetric(random, change) + firm * Matrix3::Identity());
      const Matrix3 A = C * J.transpose().inverse() * motors * J.transpose() * axes;
      ForcePose pose{J, {}};
      for (int repeat = 0; repeat < 1; ++repeat)
        for (int axis = 0; axis < 3; ++axis)
          for (const double sign : {1.0, -1.0}) {
            const Vector3 u = sign * Vector3::Unit(axis);
            Vector3 response = A * u;
            for (auto& component : response) component += random.normal(noise * compliance);
            pose.ramps.push_back({u, response});
          }
      poses.push_back(pose);
    }
    return poses;
  }
  ForceCheck check(std::uint64_t seed) const {
    const auto found = check_forces(play(seed));
    EXPECT_TRUE(found) << (found ? "" : found.error().message);
    return found.value_or(ForceCheck{});
  }
  std::map<ForceVerdict, int> verdicts(int seeds) const {
    std::map<ForceVerdict, int> counted;
    for (int seed = 1; seed <= seeds; ++seed) ++counted[check(static_cast<std::uint64_t>(seed)).verdict];
    return counted;
  }
};

Matrix3 exchanged(int i, int j) {
  Matrix3 P = Matrix3::Identity();
  P.col(i).swap(P.col(j));
  return P;
}
Matrix3 with_gain(int i, double gain) {
  Matrix3 S = Matrix3::Identity();
  S(i, i) = gain;
  return S;
}

std::string shown(const std::map<ForceVerdict, int>& verdicts) {
  std::string text;
  for (const auto& [verdict, count] : verdicts)
    text += std::string(name_of(verdict)) + " " + std::to_string(count) + ", ";
  return text;
}

TEST(ForceCheckStatistics, Explore) {
  const int seeds = 20;
  setbuf(stdout, nullptr);
  for (double s : {0.0, 0.2, 0.35, 0.5}) {
    Trial t;
    t.anisotropy = s;
    std::printf("healthy, anisotropy %.2f: %s\n", s, shown(t.verdicts(seeds)).c_str());
    double sd = 0, cost = 0, next = 1e9;
    for (int seed = 1; seed <= 20; ++seed) {
      const auto c = t.check(seed);
      sd += c.covariance.diagonal().cwiseSqrt().maxCoeff() / 20, cost += c.cost / 20,
          next = std::min(next, c.next_cost - c.cost);
    }
    std::printf("   sd %.3f cost %.1f next %.1f\n", sd, cost, next);
  }
  for (int i = 0; i < 3; ++i) {
    Trial t;
    t.axes = with_gain(i, -1.0);
    std::printf("axis %d mirrored: %s\n", i, shown(t.verdicts(seeds)).c_str());
    t = {};
    t.motors = with_gain(i, -1.0);
    std::printf("joint %d mirrored: %s\n", i, shown(t.verdicts(seeds)).c_str());
    t.motors = with_gain(i, 0.0);
    std::printf("joint %d off: %s\n", i, shown(t.verdicts(seeds)).c_str());
    for (double g : {0.5, 1.2, 2.0}) {
      t.motors = with_gain(i, g);
      std::printf("joint %d gain %.1f: %s\n", i, g, shown(t.verdicts(seeds)).c_str());
    }
    t.motors = exchanged(i, (i + 1) % 3);
    std::printf("joints %d %d exchanged: %s\n", i, (i + 1) % 3, shown(t.verdicts(seeds)).c_str());
    t = {};
    t.axes = exchanged(i, (i + 1) % 3);
    std::printf("axes %d %d exchanged: %s\n", i, (i + 1) % 3, shown(t.verdicts(seeds)).c_str());
  }
  Trial t;
  t.noise = 0.8;
  std::printf("restless: %s\n", shown(t.verdicts(seeds)).c_str());
  t.noise = 0.3;
  std::printf("noise .3: %s\n", shown(t.verdicts(seeds)).c_str());
  t = {};
  t.angles.resize(1);
  std::printf("one pose: %s\n", shown(t.verdicts(seeds)).c_str());
}

}  // namespace
}  // namespace palpate::calibration
