#include "palpate/calibration/noise/smooth_error.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "palpate/math/linear_algebra.h"

namespace palpate::calibration::noise {
namespace {

// Lengths of the field in units of the motion's rms extent: from what changes between neighbouring views to
// what is all but linear over the whole recording.
constexpr std::array kLengths{0.25, 0.5, 1.0, 2.0};
// Variance of the field against that of one observation's white noise.
constexpr std::array kRatios{0.0, 1e-3, 3e-3, 1e-2, 3e-2, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 1000.0};

double squared_distance(const PoseErrors& e, std::size_t i, std::size_t j) {
  const double turn = e.lever * angle_between(e.turn[i], e.turn[j]);
  return (e.place[i] - e.place[j]).squaredNorm() + turn * turn;
}

// What one component says for one ratio of field to white noise: its part of the normal equations J' V^-1 J,
// J' V^-1 r, r' V^-1 r and log |V|, V the variance of its residuals; and the field's variance.
struct FieldPart {
  Eigen::MatrixXd N;
  Eigen::VectorXd b;
  double q = 0.0, log_det = 0.0, field_variance = 0.0;
};
using FieldComponent = std::vector<FieldPart>;  // by ratio

double log_determinant(const Eigen::MatrixXd& N) {
  double sum = 0.0;
  const Eigen::VectorXd values = symmetric_eigenvalues(N);
  for (double value : values) sum += std::log(std::max(value, 1e-12 * values.maxCoeff()));
  return sum;
}

// r and J in the eigenvectors of the kernel, whose values are given. The white variance is the one that fits
// this component alone best, as many columns projected out as it has.
FieldComponent component_of(const Eigen::VectorXd& r, const Eigen::MatrixXd& J,
                            const Eigen::VectorXd& values) {
  FieldComponent parts;
  for (double ratio : kRatios) {
    const Eigen::ArrayXd total = 1.0 + ratio * values.array().max(0.0);
    const Eigen::MatrixXd weighted = total.inverse().matrix().asDiagonal() * J;
    FieldPart part;
    part.N = J.transpose() * weighted;
    part.b = weighted.transpose() * r;
    part.q = (r.array().square() / total).sum();
    const double n = static_cast<double>(r.size()), freedom = n - static_cast<double>(J.cols());
    const double left = std::max(0.0, part.q - part.b.dot(pseudo_inverse_symmetric(part.N) * part.b));
    const double white = std::max(1e-300, left / freedom);
    part.N /= white, part.b /= white, part.q /= white;
    part.log_det = n * std::log(white) + total.log().sum();
    part.field_variance = ratio * white;
    parts.push_back(part);
  }
  return parts;
}

// Restricted log likelihood of all components together, at one ratio each.
double likelihood(const std::vector<FieldComponent>& components, const std::vector<std::size_t>& ratio) {
  Eigen::MatrixXd N = Eigen::MatrixXd::Zero(components[0][0].N.rows(), components[0][0].N.cols());
  Eigen::VectorXd b = Eigen::VectorXd::Zero(N.rows());
  double q = 0.0, log_det = 0.0;
  for (std::size_t c = 0; c < components.size(); ++c) {
    const FieldPart& part = components[c][ratio[c]];
    N += part.N, b += part.b, q += part.q, log_det += part.log_det;
  }
  return -0.5 * (log_det + log_determinant(N) + q - b.dot(solve_symmetric(N, b)));
}

struct FieldJudgement {
  double log_evidence = 0.0;       // of the length, the ratios averaged out
  Eigen::VectorXd field_variance;  // square of the deviation's mean over the ratios
};

// Climbs to the likeliest ratios, one component at a time, then averages about them.
FieldJudgement judge(const std::vector<FieldComponent>& components) {
  std::vector<std::size_t> ratio(components.size(), kRatios.size() / 2);
  FieldJudgement result{0.0, Eigen::VectorXd::Zero(static_cast<Eigen::Index>(components.size()))};
  for (int sweep = 0; sweep < 20; ++sweep) {
    const auto before = ratio;
    double averaged = 0.0, best = 0.0;
    for (std::size_t c = 0; c < components.size(); ++c) {
      std::array<double, kRatios.size()> log_likelihood{};
      for (std::size_t k = 0; k < kRatios.size(); ++k)
        ratio[c] = k, log_likelihood[k] = likelihood(components, ratio);
      ratio[c] = static_cast<std::size_t>(std::max_element(log_likelihood.begin(), log_likelihood.end()) -
                                          log_likelihood.begin());
      best = log_likelihood[ratio[c]];
      double sum = 0.0, mean = 0.0;
      for (std::size_t k = 0; k < kRatios.size(); ++k) {
        const double weight = std::exp(log_likelihood[k] - best);
        sum += weight, mean += weight * std::sqrt(components[c][k].field_variance);
      }
      result.field_variance[static_cast<Eigen::Index>(c)] = (mean / sum) * (mean / sum);
      averaged += std::log(sum);
    }
    result.log_evidence = best + averaged;
    if (ratio == before) break;
  }
  return result;
}

// Covariance of the parameters from a field of these variances that keeps to axes of its own.
Eigen::MatrixXd in_fixed_axes(const PoseErrors& errors, const Eigen::VectorXd& variance,
                              const Eigen::MatrixXd& kernel) {
  const auto n = kernel.rows(), components = variance.size(), parameters = errors.influence.front().rows();
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(components, components);
  std::vector<Eigen::MatrixXd> influence(static_cast<std::size_t>(components),
                                         Eigen::MatrixXd(parameters, n));
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::MatrixXd& axes = errors.axes[static_cast<std::size_t>(i)];
    const Eigen::MatrixXd back = axes.inverse();
    scatter += back * variance.asDiagonal() * back.transpose() / static_cast<double>(n);
    for (Eigen::Index c = 0; c < components; ++c) {
      auto column = influence[static_cast<std::size_t>(c)].col(i);
      column.setZero();
      for (Eigen::Index k = 0; k < components; ++k)
        column += axes(k, c) * errors.influence[static_cast<std::size_t>(k)].col(i);
    }
  }
  // Half of it alike in all directions: what the axes' own scatters say of one another is little, and an
  // error along the line of sight hides best.
  Eigen::MatrixXd round = Eigen::MatrixXd::Zero(components, components);
  for (Eigen::Index c = 0; c < components; c += 3)
    round.block<3, 3>(c, c).diagonal().setConstant(scatter.block<3, 3>(c, c).trace() / 3.0);
  scatter = 0.5 * (scatter + round);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(parameters, parameters);
  for (Eigen::Index a = 0; a < components; ++a) {
    const Eigen::MatrixXd spread = influence[static_cast<std::size_t>(a)] * kernel;
    for (Eigen::Index b = 0; b < components; ++b)
      covariance += scatter(a, b) * (spread * influence[static_cast<std::size_t>(b)].transpose());
  }
  return covariance;
}

Eigen::MatrixXd squared_distances(const PoseErrors& errors) {
  const auto n = static_cast<Eigen::Index>(errors.place.size());
  Eigen::MatrixXd distance(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      distance(i, j) = distance(j, i) =
          squared_distance(errors, static_cast<std::size_t>(i), static_cast<std::size_t>(j));
  return distance;
}

Eigen::MatrixXd kernel_of(const Eigen::MatrixXd& distance, double length) {
  return (-distance.array() / (2.0 * length * length)).exp();
}

}  // namespace

Eigen::MatrixXd smooth_error_covariance(const PoseErrors& errors, const SmoothError& told) {
  const auto parameters = errors.influence.front().rows();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(parameters, parameters);
  const Eigen::MatrixXd distance = squared_distances(errors);
  for (const auto& candidate : told.candidates) {
    const Eigen::MatrixXd kernel = kernel_of(distance, candidate.length);
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(parameters, parameters);
    for (Eigen::Index c = 0; c < candidate.variance.size(); ++c) {
      const auto& G = errors.influence[static_cast<std::size_t>(c)];
      covariance += candidate.variance[c] * (G * kernel * G.transpose());
    }
    if (!errors.axes.empty())
      covariance = 0.5 * (covariance + in_fixed_axes(errors, candidate.variance, kernel));
    sum += candidate.weight * covariance;
  }
  return sum;
}

SmoothError smooth_error(const PoseErrors& errors) {
  const auto n = static_cast<Eigen::Index>(errors.place.size());
  const auto components = errors.residual.cols();
  const auto parameters = errors.influence.front().rows();
  SmoothError result{
      Eigen::MatrixXd::Zero(parameters, parameters), Eigen::VectorXd::Zero(components), 0.0, {}};
  if (n < 12) return result;
  const Eigen::MatrixXd distance = squared_distances(errors);
  const double extent = std::sqrt(0.5 * distance.mean());  // rms distance from the middle
  if (!(extent > 0.0)) return result;

  const Eigen::VectorXd root = errors.white.cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd& first = errors.jacobian.front();
  if (n < first.cols() + 6) return result;  // nothing is left to see a field in
  Eigen::VectorXd norms = Eigen::VectorXd::Zero(first.cols());
  for (const auto& J : errors.jacobian) norms += J.colwise().squaredNorm().transpose();
  const Eigen::VectorXd column = norms.cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  std::array<double, kLengths.size()> evidence{};
  for (std::size_t l = 0; l < kLengths.size(); ++l) {
    const double length = kLengths[l] * extent;
    const auto eigen = symmetric_eigen(root.asDiagonal() * kernel_of(distance, length) * root.asDiagonal());
    std::vector<FieldComponent> told;
    for (Eigen::Index c = 0; c < components; ++c) {
      const auto& J = errors.jacobian[static_cast<std::size_t>(c)];
      told.push_back(component_of(eigen.vectors.transpose() * (root.asDiagonal() * errors.residual.col(c)),
                                  eigen.vectors.transpose() * (root.asDiagonal() * J * column.asDiagonal()),
                                  eigen.values));
    }
    const auto judged = judge(told);
    evidence[l] = judged.log_evidence;
    result.candidates.push_back({length, 0.0, judged.field_variance});
  }
  const double best = *std::max_element(evidence.begin(), evidence.end());
  double sum = 0.0;
  for (double value : evidence) sum += std::exp(value - best);
  double log_length = 0.0;
  for (std::size_t l = 0; l < kLengths.size(); ++l) {
    auto& candidate = result.candidates[l];
    candidate.weight = std::exp(evidence[l] - best) / sum;
    result.field_sd += candidate.weight * candidate.variance;
    log_length += candidate.weight * std::log(candidate.length);
  }
  result.field_sd = result.field_sd.cwiseSqrt();
  result.length = std::exp(log_length);
  result.covariance = smooth_error_covariance(errors, result);
  return result;
}

}  // namespace palpate::calibration::noise
