#include "palpate/calibration/arm_uncertainty.h"

#include <algorithm>
#include <cmath>

#include "palpate/calibration/robust_scale.h"
#include "palpate/estimation/linear_algebra.h"

namespace palpate {
namespace {

// Directions the data leave to the prior: singular values of the Jacobian, columns in units of what is
// plausible, rows in units of the noise, below 1. Each is named by its largest parts.
std::vector<std::string> name_unobservable(const Eigen::MatrixXd& J,
                                           const std::vector<ArmParameter>& parameters, double scale) {
  Eigen::VectorXd sizes(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t k = 0; k < parameters.size(); ++k)
    sizes[static_cast<Eigen::Index>(k)] = parameters[k].size;
  const Eigen::MatrixXd scaled = J * sizes.asDiagonal() / scale;
  const auto svd = singular_values(scaled);
  std::vector<std::string> names;
  for (Eigen::Index k = 0; k < svd.values.size(); ++k) {
    if (svd.values[k] >= 1.0) continue;
    const Eigen::VectorXd v = svd.V.col(k).cwiseAbs();
    double largest = 0.0;
    for (std::size_t p = 0; p < parameters.size(); ++p)
      if (!parameters[p].of_base()) largest = std::max(largest, v[static_cast<Eigen::Index>(p)]);
    std::string name;
    for (std::size_t p = 0; p < parameters.size(); ++p)
      if (!parameters[p].of_base() && v[static_cast<Eigen::Index>(p)] > 0.5 * largest)
        name += (name.empty() ? "" : "+") + parameters[p].name;
    if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

double condition_of(const Eigen::MatrixXd& J) {
  Eigen::VectorXd norms = J.colwise().norm().transpose();
  for (double& n : norms) n = n > 0.0 ? 1.0 / n : 0.0;
  const Eigen::VectorXd values = singular_values(J * norms.asDiagonal()).values;
  return values[0] / std::max(values[values.size() - 1], 1e-300);
}

}  // namespace

void add_arm_covariance(Estimate<ArmSolution>& estimate, const ArmSetting& setting,
                        const std::vector<ArmParameter>& parameters) {
  const auto P = static_cast<Eigen::Index>(parameters.size());
  Eigen::MatrixXd J(3 * static_cast<Eigen::Index>(setting.samples.size()), P);
  Eigen::Matrix3Xd row(3, P);
  Eigen::Index rows = 0;
  double chi2 = 0.0;
  for (const auto& sample : setting.samples) {
    if (sample.weight == 0.0) continue;
    chi2 += (sample.whitening *
             arm_residual(estimate.value, *sample.observation, sample.motion, parameters, &row))
                .squaredNorm();
    J.middleRows<3>(rows) = sample.whitening * row;
    rows += 3;
  }
  J.conservativeResize(rows, P);
  const double sigma = std::max(kLeastScale, std::sqrt(chi2 / std::max(1.0, static_cast<double>(rows - P))));
  Eigen::MatrixXd information = J.transpose() * J / (sigma * sigma);
  for (Eigen::Index k = 0; k < P; ++k)
    if (!parameters[static_cast<std::size_t>(k)].of_base())
      information(k, k) +=
          1.0 / (parameters[static_cast<std::size_t>(k)].size * parameters[static_cast<std::size_t>(k)].size);
  // scaled by its diagonal before inverting: the entries differ by many orders of magnitude
  const Eigen::VectorXd d = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = d.asDiagonal() * information * d.asDiagonal();
  estimate.covariance = d.asDiagonal() * inverse_symmetric(scaled) * d.asDiagonal();
  estimate.condition = condition_of(J);
  estimate.unobservable = name_unobservable(J, parameters, std::max(sigma, 1e-7));
  if (setting.nominal.model.kind == ArmModel::Kind::phantom)
    estimate.unobservable.insert(estimate.unobservable.begin(), "offset_1");
  estimate.value.parameters.clear();
  for (const auto& parameter : parameters) estimate.value.parameters.push_back(parameter.name);
}

}  // namespace palpate
