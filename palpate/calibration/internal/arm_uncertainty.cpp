#include "palpate/calibration/internal/arm_uncertainty.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/calibration/noise/correlated_errors.h"
#include "palpate/calibration/noise/robust_scale.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

// Directions the data leave to the prior: singular values of the Jacobian, columns in units of what is
// plausible, rows in units of the noise, below 1. Each is named by its largest parts.
std::vector<std::string> name_unobservable(const Eigen::MatrixXd& JtJ,
                                           const std::vector<ArmParameter>& parameters, double scale) {
  Eigen::VectorXd sizes(static_cast<Eigen::Index>(parameters.size()));
  for (std::size_t k = 0; k < parameters.size(); ++k)
    sizes[static_cast<Eigen::Index>(k)] = parameters[k].size;
  sizes /= scale;
  // squares of the singular values, rising
  const auto eigen = symmetric_eigen(sizes.asDiagonal() * JtJ * sizes.asDiagonal());
  std::vector<std::string> names;
  for (Eigen::Index k = eigen.values.size(); k-- > 0;) {
    if (eigen.values[k] >= 1.0) continue;
    const Eigen::VectorXd v = eigen.vectors.col(k).cwiseAbs();
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

double condition_of(const Eigen::MatrixXd& JtJ) {
  Eigen::VectorXd norms = JtJ.diagonal().cwiseSqrt();
  for (double& n : norms) n = n > 0.0 ? 1.0 / n : 0.0;
  const Eigen::VectorXd squares =
      symmetric_eigenvalues(norms.asDiagonal() * JtJ * norms.asDiagonal());  // rising
  const double most = squares[squares.size() - 1];  // what is below its rounding is not told apart from zero
  return std::sqrt(most / std::max(squares[0], most * std::numeric_limits<double>::epsilon()));
}

}  // namespace

void add_arm_covariance(Estimate<ArmSolution>& estimate, const ArmSetting& setting,
                        const std::vector<ArmParameter>& parameters, bool allow_field) {
  const auto P = static_cast<Eigen::Index>(parameters.size());
  noise::CorrelationInput input;
  std::vector<WeighedSample> inliers;
  for (const auto& sample : setting.samples)
    if (sample.weight > 0.0) inliers.push_back(sample);
  input.residuals = whitened_residuals(inliers, estimate.value, parameters, &input.J);
  for (const auto& sample : inliers) {
    const auto& observed = *sample.observation;
    // The tracker's error belongs to where the LEDs are, a stylus away from the tip.
    input.places.push_back(observed.marker ? observed.marker->translation : observed.tip->m);
    input.levers.push_back(observed.marker ? Matrix3(sample.whitening * hat(observed.marker->rotation *
                                                                            estimate.value.tip_in_marker))
                                           : Matrix3(Matrix3::Zero()));
  }
  const Eigen::MatrixXd& J = input.J;
  const Eigen::VectorXd& r = input.residuals;
  const Eigen::MatrixXd JtJ = gram(J);
  const Eigen::Index rows = r.size();
  const double freedom = std::max(1.0, static_cast<double>(rows - P));
  const double sigma = std::max(noise::kLeastScale, std::sqrt(r.squaredNorm() / freedom));
  input.precision = Eigen::MatrixXd::Zero(P, P);
  for (Eigen::Index k = 0; k < P; ++k) {
    const auto& parameter = parameters[static_cast<std::size_t>(k)];
    if (!parameter.of_base()) input.precision(k, k) = sigma * sigma / (parameter.size * parameter.size);
  }
  input.stated_variance = setting.stated_variance;
  input.stated_share = allow_field ? setting.stated_share : std::optional<double>(0.0);
  if (rows > P && sigma > noise::kLeastScale) {
    const auto errors = noise::correlated_covariance(input);
    estimate.covariance = errors.covariance;
    estimate.value.noise = {errors.sigma, errors.share, errors.reach};
  } else {
    estimate.covariance = sigma * sigma * covariance_from_information(JtJ + input.precision);
    estimate.value.noise = {sigma, 0.0, 0.0};
  }
  // Where the noise is known from few residuals only: the variance of Student's distribution.
  if (freedom > 4.0 && setting.stated_variance == 0.0) estimate.covariance *= freedom / (freedom - 2.0);
  estimate.condition = condition_of(JtJ);
  estimate.unobservable = name_unobservable(JtJ, parameters, std::max(sigma, 1e-7));
  if (setting.nominal.model.kind == device::ArmModel::Kind::phantom)
    estimate.unobservable.insert(estimate.unobservable.begin(), "offset_1");
  estimate.value.parameters.clear();
  for (const auto& parameter : parameters) estimate.value.parameters.push_back(parameter.name);
}

}  // namespace palpate::calibration
