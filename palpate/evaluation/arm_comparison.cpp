#include "palpate/evaluation/arm_comparison.h"

#include "palpate/core/random.h"

namespace palpate::evaluation {

std::vector<Vector3> judging_poses(const sim::config::WorldFile& world, std::uint64_t seed, int count) {
  Random random(seed, "demo/judging poses");
  std::vector<Vector3> poses;
  for (int i = 0; i < count; ++i) {
    Vector3 psi;
    for (Eigen::Index j = 0; j < 3; ++j) {
      const auto& range = world.arm.joint_range[static_cast<std::size_t>(j)];
      psi[j] = random.uniform(range[0], range[1]);
    }
    poses.push_back(psi);
  }
  return poses;
}

Expected<std::vector<MethodErrors>> compare_arm_methods(const std::vector<device::ArmObservation>& train,
                                                        const std::vector<device::ArmObservation>& test,
                                                        const device::PhantomLengths& nominal,
                                                        const Vector3& tip, const sim::Truth& truth,
                                                        const std::vector<Vector3>& poses) {
  const device::ArmModel model{.lengths = nominal};
  calibration::ArmOptions options;
  options.free.lengths = false;
  options.tip = tip;
  std::vector<MethodErrors> result;
  const auto add = [&](const std::string& name,
                       Expected<Estimate<calibration::ArmSolution>> estimate) -> Expected<void> {
    if (!estimate) return tl::unexpected(estimate.error());
    MethodErrors errors;
    errors.method = name;
    errors.solution = estimate->value;
    errors.held_out_mean = mean_norm(calibration::arm_errors(estimate->value, test));
    for (const auto& psi : poses) {
      const Vector3 real =
          (truth.X_world_base * device::phantom_tip(truth.joints.apply(psi), truth.lengths)).m;
      errors.differences.push_back(calibration::predict_tip(estimate->value, psi).m - real);
      errors.errors.push_back(errors.differences.back().norm());
      errors.error_to_truth_mean += errors.errors.back() / static_cast<double>(poses.size());
    }
    result.push_back(std::move(errors));
    return {};
  };
  if (auto done = add("uncorrected", calibration::uncorrected_arm(train, model, options)); !done)
    return tl::unexpected(done.error());
  for (const auto& [name, method] : {std::pair{"one-pass", calibration::ArmMethod::one_pass},
                                     {"alternating", calibration::ArmMethod::alternating},
                                     {"eq7", calibration::ArmMethod::eq7},
                                     {"joint", calibration::ArmMethod::joint}}) {
    options.method = method;
    if (auto done = add(name, calibration::calibrate_arm(train, model, options)); !done)
      return tl::unexpected(done.error());
  }
  return result;
}

}  // namespace palpate::evaluation
