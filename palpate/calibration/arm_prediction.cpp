#include "palpate/calibration/arm_prediction.h"

#include <algorithm>
#include <cmath>

#include "palpate/calibration/internal/arm_problem.h"

namespace palpate::calibration {
namespace {

constexpr int kMostPerJoint = 7;
constexpr double kMostPlaces = 1000.0;

Matrix3 covariance_at(const Estimate<ArmSolution>& estimate, const std::vector<ArmParameter>& parameters,
                      const Eigen::VectorXd& psi) {
  Eigen::Matrix3Xd J;
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(psi.size());
  predicted_tip_derivatives(estimate.value, {psi, rest, rest}, parameters, J);
  return J * estimate.covariance * J.transpose();
}

}  // namespace

Matrix3 predicted_covariance(const Estimate<ArmSolution>& estimate, const Eigen::VectorXd& psi) {
  return covariance_at(estimate, parameters_named(estimate.value.model, estimate.value.parameters), psi);
}

PredictedErrorMap predicted_error_map(const Estimate<ArmSolution>& estimate,
                                      const std::vector<device::ArmObservation>& samples) {
  PredictedErrorMap map;
  if (samples.empty() || estimate.covariance.size() == 0) return map;
  const auto parameters = parameters_named(estimate.value.model, estimate.value.parameters);
  Eigen::VectorXd low = samples[0].joints, high = samples[0].joints;
  for (const auto& sample : samples) {
    low = low.cwiseMin(sample.joints);
    high = high.cwiseMax(sample.joints);
  }
  const auto n = low.size();
  const int per_joint =
      std::clamp(static_cast<int>(std::floor(std::pow(kMostPlaces, 1.0 / static_cast<double>(n)) + 1e-9)), 2,
                 kMostPerJoint);
  std::vector<int> at(static_cast<std::size_t>(n), 0);
  double square = 0.0;
  for (bool more = true; more;) {
    Eigen::VectorXd psi(n);
    for (Eigen::Index j = 0; j < n; ++j)
      psi[j] = low[j] + (high[j] - low[j]) * at[static_cast<std::size_t>(j)] / (per_joint - 1.0);
    const double variance = covariance_at(estimate, parameters, psi).trace();
    map.places.push_back({psi, predict_tip(estimate.value, psi), std::sqrt(std::max(0.0, variance))});
    square += variance;
    if (map.places.back().sd > map.worst.sd) map.worst = map.places.back();
    more = false;
    for (std::size_t j = 0; j < at.size() && !more; ++j) {
      more = ++at[j] < per_joint;
      if (!more) at[j] = 0;
    }
  }
  map.rms = std::sqrt(square / static_cast<double>(map.places.size()));
  return map;
}

}  // namespace palpate::calibration
