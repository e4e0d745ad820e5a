// The arm's calibration beside the paper's three ways on the same samples, and all of them beside the truth.
#pragma once

#include <string>
#include <vector>

#include "palpate/calibration/arm.h"
#include "palpate/sim/truth.h"

namespace palpate::evaluation {

struct MethodErrors {
  std::string method;  // uncorrected, one-pass, alternating, eq7, joint
  calibration::ArmSolution solution;
  double held_out_mean = 0.0;        // m, against the tracker, unused samples
  double error_to_truth_mean = 0.0;  // m, over the poses
  std::vector<double> errors;        // m, one per pose
  std::vector<Vector3> differences;  // m, estimate minus truth, one per pose
};

// Joint angles psi as the encoders would read them, uniform in the joint range: the poses errors are judged
// at.
std::vector<Vector3> judging_poses(const sim::config::WorldFile& world, std::uint64_t seed, int count = 1000);

// `tip` as known (from the pivot, or the truth to show what a perfect tip would change).
Expected<std::vector<MethodErrors>> compare_arm_methods(const std::vector<device::ArmObservation>& train,
                                                        const std::vector<device::ArmObservation>& test,
                                                        const device::PhantomLengths& nominal,
                                                        const Vector3& tip, const sim::Truth& truth,
                                                        const std::vector<Vector3>& poses);

}  // namespace palpate::evaluation
