#include "palpate/calibration/internal/pivot_covariance.h"

#include <cmath>

#include "palpate/core/random.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

constexpr int kDraws = 200;                // a standard deviation to 5 %
constexpr std::size_t kPivotGroups = 200;  // of neighbouring poses, for the field

// Residual c_s - (R t + p) + Q g by tip, pivots and Q's rotation.
struct LinearPivot {
  Eigen::Index tip = -1, turn = -1, delay = -1, first_pivot = 0, size = 0;
  std::vector<Eigen::MatrixXd> J;  // 3 x size, one per pose
  Eigen::MatrixXd inverse;         // of sum w J' J

  LinearPivot(const PivotData& data, const PivotErrors& how) {
    if (how.tip_free) tip = 0, first_pivot = 3;
    size = first_pivot + 3 * static_cast<Eigen::Index>(data.segments);
    if (how.turn_free) turn = size, size += 3;
    if (how.turn_free && data.rate.size() == data.size()) delay = size, size += 1;
    Eigen::MatrixXd N = Eigen::MatrixXd::Zero(size, size);
    for (std::size_t i = 0; i < data.size(); ++i) {
      J.push_back(Eigen::MatrixXd::Zero(3, size));
      if (tip >= 0) J.back().middleCols(tip, 3) = -data.R[i];
      J.back().middleCols(pivot(data.segment[i]), 3) = Matrix3::Identity();
      if (turn >= 0) J.back().middleCols(turn, 3) = -hat(data.motion[i]);
      if (delay >= 0) J.back().col(delay) = data.rate[i];
      N += data.weight[i] * J.back().transpose() * J.back();
    }
    inverse = pseudo_inverse_symmetric(N);
  }
  Eigen::Index pivot(std::size_t segment) const {
    return first_pivot + 3 * static_cast<Eigen::Index>(segment);
  }
};

Eigen::MatrixXd bootstrap(const PivotData& data, const std::vector<Vector3>& residuals,
                          const LinearPivot& linear, std::uint64_t seed, int block) {
  std::vector<std::vector<std::size_t>> rows(data.segments);
  for (std::size_t i = 0; i < data.size(); ++i) rows[data.segment[i]].push_back(i);
  Random random(seed, "pivot bootstrap");
  Eigen::MatrixXd scatter = Eigen::MatrixXd::Zero(linear.size, linear.size);
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<double> times(data.size(), 0.0);
    for (const auto& of : rows) {
      std::size_t taken = 0;
      while (taken < of.size()) {  // blocks wrap around, so that the ends count as often as the middle
        const std::size_t first = random.below(of.size());
        for (int k = 0; k < block && taken < of.size(); ++k, ++taken)
          times[of[(first + static_cast<std::size_t>(k)) % of.size()]] += 1.0;
      }
    }
    Eigen::MatrixXd N = Eigen::MatrixXd::Zero(linear.size, linear.size);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(linear.size);
    for (std::size_t i = 0; i < data.size(); ++i) {
      const double w = times[i] * data.weight[i];
      if (w == 0.0) continue;
      N.noalias() += w * linear.J[i].transpose() * linear.J[i];
      b.noalias() += w * (linear.J[i].transpose() * residuals[i]);
    }
    const Eigen::VectorXd off = solve_symmetric(N, b);
    scatter += off * off.transpose() / kDraws;
  }
  return scatter;
}

noise::PoseErrors pose_errors(const PivotData& data, const std::vector<Vector3>& residuals,
                              const LinearPivot& linear) {
  noise::PoseErrors errors;
  const std::size_t size = data.size() / kPivotGroups + 1;
  std::vector<std::pair<std::size_t, std::size_t>> groups;
  for (std::size_t first = 0; first < data.size();) {
    std::size_t last = first + 1;
    while (last < data.size() && last - first < size && data.segment[last] == data.segment[first]) ++last;
    double weight = 0.0;
    for (std::size_t i = first; i < last; ++i) weight += data.weight[i];
    if (weight > 0.0) groups.emplace_back(first, last);
    first = last;
  }
  const auto n = static_cast<Eigen::Index>(groups.size());
  errors.residual = Eigen::MatrixXd::Zero(n, 3);
  errors.white = Eigen::VectorXd::Zero(n);
  errors.jacobian.assign(3, Eigen::MatrixXd::Zero(n, linear.size));
  errors.influence.assign(3, Eigen::MatrixXd::Zero(linear.size, n));
  for (Eigen::Index g = 0; g < n; ++g) {
    const auto [first, last] = groups[static_cast<std::size_t>(g)];
    const std::size_t middle = (first + last) / 2;
    errors.place.push_back(data.p[middle]);
    errors.turn.emplace_back(data.R[middle]);
    errors.axes.emplace_back(data.R[middle]);
    double total = 0.0;
    for (std::size_t i = first; i < last; ++i) total += data.weight[i];
    errors.white[g] = 1.0 / total;
    for (std::size_t i = first; i < last; ++i) {
      const double w = data.weight[i] / total;
      errors.residual.row(g) += w * residuals[i].transpose();
      for (Eigen::Index c = 0; c < 3; ++c) {
        errors.jacobian[static_cast<std::size_t>(c)].row(g) += w * linear.J[i].row(c);
        errors.influence[static_cast<std::size_t>(c)].col(g) +=
            data.weight[i] * (linear.inverse * linear.J[i].row(c).transpose());
      }
    }
  }
  return errors;
}

// An error E m_i of the motion m_i, E's nine numbers independent with unit variance.
Eigen::MatrixXd strain(const PivotData& data, const LinearPivot& linear) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(linear.size, linear.size);
  for (Eigen::Index to = 0; to < 3; ++to)
    for (Eigen::Index from = 0; from < 3; ++from) {
      Eigen::VectorXd off = Eigen::VectorXd::Zero(linear.size);
      for (std::size_t i = 0; i < data.size(); ++i)
        off += data.weight[i] * data.motion[i][from] * linear.J[i].row(to).transpose();
      off = (linear.inverse * off).eval();
      sum += off * off.transpose();
    }
  return sum;
}

}  // namespace

PivotCovariance pivot_covariance(const PivotData& data, const std::vector<Vector3>& residuals,
                                 const PivotErrors& how) {
  const LinearPivot linear(data, how);
  double square = 0.0, used = 0.0;
  for (std::size_t i = 0; i < data.size(); ++i)
    square += data.weight[i] * residuals[i].squaredNorm(), used += data.weight[i] > 0.0 ? 1.0 : 0.0;
  const double freedom = 3.0 * used - static_cast<double>(linear.size);
  PivotCovariance result;
  const noise::PoseErrors errors = pose_errors(data, residuals, linear);
  result.field = how.field != nullptr ? *how.field : noise::smooth_error(errors);
  Eigen::MatrixXd total =
      square / std::max(freedom, 1.0) * linear.inverse + noise::smooth_error_covariance(errors, result.field);
  if (how.motion_strain > 0.0) total += how.motion_strain * how.motion_strain * strain(data, linear);

  const double correlation = integrated_correlation(data, residuals);
  const auto quarter = std::max<std::size_t>(1, data.size() / data.segments / 4);
  result.block =
      static_cast<int>(std::clamp<double>(std::ceil(2.0 * correlation), 1.0, static_cast<double>(quarter)));
  const Eigen::MatrixXd drawn = bootstrap(data, residuals, linear, how.seed, result.block);
  const auto excess = [&](Eigen::Index first, Eigen::Index count) {
    return drawn.diagonal().segment(first, count).sum() /
           std::max(total.diagonal().segment(first, count).sum(), 1e-300);
  };
  double growth = std::max(1.0, excess(linear.first_pivot, 3 * static_cast<Eigen::Index>(data.segments)));
  if (how.tip_free) {
    growth = std::max(growth, excess(0, 3));
    result.bootstrap_std = drawn.diagonal().head<3>().cwiseSqrt();
  }
  total *= growth;
  // Tip and pivots; a given tip has no variance.
  const auto S3 = 3 * static_cast<Eigen::Index>(data.segments);
  result.total = Eigen::MatrixXd::Zero(3 + S3, 3 + S3);
  if (how.tip_free)
    result.total = total.topLeftCorner(3 + S3, 3 + S3);
  else
    result.total.bottomRightCorner(S3, S3) = total.topLeftCorner(S3, S3);
  return result;
}

}  // namespace palpate::calibration
