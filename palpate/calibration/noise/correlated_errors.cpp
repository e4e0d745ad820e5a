#include "palpate/calibration/noise/correlated_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "palpate/math/linear_algebra.h"

namespace palpate::calibration::noise {
namespace {

constexpr std::array kShares{0.15, 0.35, 0.6, 0.85};
constexpr std::array kReaches{0.25, 0.5, 1.0, 2.0};  // of the places' extent
constexpr double kPriorOfWhite = 0.8;
constexpr double kPriorOfStated = 0.7;      // that the stated variance is right
constexpr double kUnknownScale = 4.6;       // else log s is uniform over so much: a factor of ten each way
constexpr std::size_t kMostPlaces = 100;    // the likelihood costs their cube
constexpr std::size_t kMostOfMiddle = 400;  // J^T K J their square
constexpr double kLeastShare = 1e-6, kMostShare = 0.95;

Vector3 middle_of(const std::vector<Vector3>& places) {
  Vector3 mean = Vector3::Zero();
  for (const auto& p : places) mean += p / static_cast<double>(places.size());
  return mean;
}

// Some of the places, so that no more than `most` are left: every so many of them in the order of their
// distances from the middle, which is the same in whatever order they were recorded.
struct Thinned {
  std::vector<Vector3> places;
  Eigen::MatrixXd J;  // component by component: all x rows, then y, then z
  Eigen::VectorXd r;
};

Thinned thinned(const std::vector<Vector3>& places, const Eigen::MatrixXd& J, const Eigen::VectorXd& r,
                std::size_t most) {
  Thinned few;
  const std::size_t stride = (places.size() + most - 1) / most;
  std::vector<std::pair<double, std::size_t>> by_distance;
  const Vector3 middle = middle_of(places);
  for (std::size_t i = 0; i < places.size(); ++i)
    by_distance.emplace_back((places[i] - middle).squaredNorm(), i);
  if (stride > 1) std::sort(by_distance.begin(), by_distance.end());
  std::vector<Eigen::Index> rows;
  for (std::size_t k = 0; k < by_distance.size(); k += stride) {
    const std::size_t i = by_distance[k].second;
    few.places.push_back(places[i]);
    rows.push_back(3 * static_cast<Eigen::Index>(i));
  }
  const auto n = static_cast<Eigen::Index>(rows.size());
  few.J.resize(3 * n, J.cols());
  few.r.resize(3 * n);
  for (Eigen::Index c = 0; c < 3; ++c)
    for (Eigen::Index i = 0; i < n; ++i) {
      few.J.row(c * n + i) = J.row(rows[static_cast<std::size_t>(i)] + c);
      few.r[c * n + i] = r[rows[static_cast<std::size_t>(i)] + c];
    }
  return few;
}

double extent_of(const std::vector<Vector3>& places) {
  const Vector3 middle = middle_of(places);
  double square = 0.0;
  for (const auto& p : places) square += (p - middle).squaredNorm() / static_cast<double>(places.size());
  return 2.0 * std::sqrt(square);
}

Eigen::MatrixXd resemblance(const std::vector<Vector3>& places, double reach) {
  const auto n = static_cast<Eigen::Index>(places.size());
  Eigen::MatrixXd K(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      K(i, j) = K(j, i) = std::exp(
          -(places[static_cast<std::size_t>(i)] - places[static_cast<std::size_t>(j)]).squaredNorm() /
          (2.0 * reach * reach));
  return K;
}

// Sum over the components of J_c^T K J_c, scaled up to `count` samples from those that are left.
Eigen::MatrixXd resembling(const Thinned& data, double reach, double count) {
  const Eigen::MatrixXd K = resemblance(data.places, reach);
  const Eigen::Index n = K.rows();
  const double scale = count / static_cast<double>(n);
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(data.J.cols(), data.J.cols());
  for (Eigen::Index c = 0; c < 3; ++c) {
    const Eigen::MatrixXd Jc = data.J.middleRows(c * n, n);
    sum.noalias() += scale * scale * (Jc.transpose() * (K * Jc));
  }
  return sum;
}

// How a turn of each marker enters the estimate: lever^T J, sample by sample.
Eigen::MatrixXd turning(const CorrelationInput& input) {
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(input.J.rows(), input.J.cols());
  for (std::size_t i = 0; i < input.levers.size(); ++i) {
    const auto row = 3 * static_cast<Eigen::Index>(i);
    M.middleRows<3>(row) = input.levers[i].transpose() * input.J.middleRows<3>(row);
  }
  return M;
}

double log_determinant_of_factor(const Eigen::MatrixXd& L) { return 2.0 * L.diagonal().array().log().sum(); }

struct Likelihood {
  double of_free = -1e300, of_stated = -1e300;  // log; s^2 integrated out, and s^2 as stated
  double variance = 0.0;                        // s^2 at its best
};

// Restricted log-likelihood of V = s^2 V0; an empty V0 is the identity.
Likelihood restricted_likelihood(const Thinned& data, const Eigen::MatrixXd& V0,
                                 const Eigen::MatrixXd& precision, double stated_variance) {
  const bool white = V0.size() == 0;
  Eigen::MatrixXd L;
  if (!white && !lower_cholesky(V0, L)) return {};
  const auto n = static_cast<Eigen::Index>(data.places.size());
  const Eigen::Index P = data.J.cols();
  Eigen::MatrixXd A = precision;
  Eigen::VectorXd b = Eigen::VectorXd::Zero(P);
  double square = 0.0;
  for (Eigen::Index c = 0; c < 3; ++c) {
    Eigen::MatrixXd Z(n, P + 1);
    Z << data.J.middleRows(c * n, n), data.r.segment(c * n, n);
    if (!white) L.triangularView<Eigen::Lower>().solveInPlace(Z);
    A.noalias() += Z.leftCols(P).transpose() * Z.leftCols(P);
    b.noalias() += Z.leftCols(P).transpose() * Z.col(P);
    square += Z.col(P).squaredNorm();
  }
  const Eigen::VectorXd d = A.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  A = d.asDiagonal() * A * d.asDiagonal();
  Eigen::MatrixXd LA;
  if (!lower_cholesky(A, LA)) return {};
  Eigen::VectorXd y = d.cwiseProduct(b);
  LA.triangularView<Eigen::Lower>().solveInPlace(y);
  const double freedom = std::max(1.0, static_cast<double>(3 * n - P));
  const double chi2 = std::max(1e-300, square - y.squaredNorm());
  const double variance = chi2 / freedom;
  const double common = 3.0 * (white ? 0.0 : log_determinant_of_factor(L)) + log_determinant_of_factor(LA) -
                        2.0 * d.array().log().sum();
  Likelihood result;
  result.variance = variance;
  const double width = std::sqrt(std::numbers::pi / freedom);  // sqrt(2 pi) times the deviation of log s
  result.of_free = -0.5 * (freedom * (std::log(variance) + 1.0) + common) + std::log(width / kUnknownScale);
  if (stated_variance > 0.0)
    result.of_stated = -0.5 * (freedom * std::log(stated_variance) + chi2 / stated_variance + common);
  return result;
}

}  // namespace

CorrelatedErrors correlated_covariance(const CorrelationInput& input) {
  const Eigen::MatrixXd& J = input.J;
  const auto& places = input.places;
  const Thinned few = thinned(places, J, input.residuals, kMostPlaces);
  const auto n = static_cast<Eigen::Index>(few.places.size());
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(n, n);
  const Eigen::MatrixXd JtJ = gram(J);
  const bool stated = input.stated_variance > 0.0;

  struct Hypothesis {
    double share, reach, log_weight, variance;
    Eigen::MatrixXd middle;  // J^T V0 J
  };
  std::vector<Hypothesis> hypotheses;
  const auto add = [&](double share, double reach, const Eigen::MatrixXd& V0, double prior,
                       const Eigen::MatrixXd& middle) {
    const auto likelihood = restricted_likelihood(few, V0, input.precision, input.stated_variance);
    const double of_free = prior * (stated ? 1.0 - kPriorOfStated : 1.0);
    hypotheses.push_back({share, reach, likelihood.of_free + std::log(of_free), likelihood.variance, middle});
    if (stated)
      hypotheses.push_back({share, reach, likelihood.of_stated + std::log(prior * kPriorOfStated),
                            input.stated_variance, middle});
  };
  const double prior_of_white =
      !input.stated_share ? kPriorOfWhite : (*input.stated_share < kLeastShare ? 1.0 : 0.0);
  if (prior_of_white > 0.0) add(0.0, 0.0, {}, prior_of_white, JtJ);
  if (prior_of_white < 1.0) {
    const Thinned all = thinned(places, J, input.residuals, kMostOfMiddle);
    const Thinned turned = thinned(places, turning(input), input.residuals, kMostOfMiddle);
    std::vector<double> shares(kShares.begin(), kShares.end());
    if (input.stated_share) shares = {std::min(*input.stated_share, kMostShare)};
    const double each = (1.0 - prior_of_white) / static_cast<double>(shares.size() * kReaches.size());
    const double extent = extent_of(places);
    for (const double part : kReaches) {
      const double reach = part * extent;
      if (!(reach > 0.0)) continue;
      const Eigen::MatrixXd K = resemblance(few.places, reach);
      const Eigen::MatrixXd field =
          resembling(all, reach, static_cast<double>(places.size())) +
          1.0 / (reach * reach) * resembling(turned, reach, static_cast<double>(places.size()));
      for (const double share : shares)
        add(share, reach, (1.0 - share) * identity + share * K, each, (1.0 - share) * JtJ + share * field);
    }
  }

  double most = -1e300, total = 0.0;
  for (const auto& h : hypotheses) most = std::max(most, h.log_weight);
  for (const auto& h : hypotheses) total += std::exp(h.log_weight - most);
  CorrelatedErrors result;
  Eigen::MatrixXd middle = Eigen::MatrixXd::Zero(J.cols(), J.cols());
  double variance = 0.0, of_field = 0.0;
  for (const auto& h : hypotheses) {
    const double weight = std::exp(h.log_weight - most) / total;
    result.share += weight * h.share;
    result.reach += weight * h.reach;
    if (h.share > 0.0) of_field += weight;
    middle += weight * h.variance * h.middle;
    variance += weight * h.variance;
  }
  if (of_field > 0.0) result.reach /= of_field;
  result.sigma = std::sqrt(variance);
  result.covariance = sandwich_covariance(JtJ + input.precision, middle + variance * input.precision);
  return result;
}

}  // namespace palpate::calibration::noise
