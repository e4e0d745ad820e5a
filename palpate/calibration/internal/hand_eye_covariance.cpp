#include "palpate/calibration/internal/hand_eye_covariance.h"

#include <algorithm>
#include <cmath>

#include "palpate/calibration/noise/smooth_error.h"
#include "palpate/math/linear_algebra.h"

namespace palpate::calibration {
namespace {

constexpr std::size_t kHandEyeGroups = 200;  // of neighbouring poses, for the field
// Two devices' clocks brought to one time line keep an offset of some 50 us, the same for a whole recording:
// it is in the delay and in no residual.
constexpr double kClockOffset = 4e-5;  // s, standard deviation

// What each pose did to the estimate, and what is needed to say what a common error would do.
struct Influences {
  HandEyeNormal inverse;  // of the loss's second derivative
  double condition = 0.0;
  std::vector<HandEyeUnknowns> score;     // inverse J' w r
  std::vector<HandEyeJacobian> weighted;  // whitened Jacobian
  std::vector<Vector6> residual;          // whitened
  std::vector<double> weight, time_s;
  std::vector<HandAt> hand;
};

Influences influences_of(const HandEyeProblem& problem, const HandEyeState& x) {
  Influences result;
  HandEyeNormal A = HandEyeNormal::Zero();
  problem.each(x, [&](std::size_t i, const HandAt& at) {
    HandEyeJacobian J;
    const Vector6 r = problem.whiten * hand_eye_residual(x, at, problem.eye[i], &J);
    if (!problem.free_delay) J.col(12).setZero();
    const HandEyeJacobian Jw = problem.whiten * J;
    const double w = cauchy_weight(r.squaredNorm(), kHandEyeCauchy);
    const HandEyeUnknowns g = Jw.transpose() * r;
    // second derivative of the loss
    A += w * Jw.transpose() * Jw - (2.0 * w * w / kHandEyeCauchy) * g * g.transpose();
    result.score.push_back(w * g);
    result.weighted.push_back(Jw);
    result.residual.push_back(r);
    result.weight.push_back(w);
    result.time_s.push_back(problem.eye[i].time_s);
    result.hand.push_back(at);
  });
  if (!problem.free_delay) A(12, 12) = 1.0;
  const HandEyeUnknowns scale = A.diagonal().cwiseAbs().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const HandEyeNormal scaled = scale.asDiagonal() * A * scale.asDiagonal();
  const auto eigen = symmetric_eigen(scaled);
  const HandEyeUnknowns values = eigen.values;
  result.condition = values(0) <= 0 ? 1e300 : std::sqrt(values(12) / values(0));
  result.inverse = scale.asDiagonal() * eigen.vectors *
                   values.cwiseMax(1e-14 * values(12)).cwiseInverse().asDiagonal() *
                   eigen.vectors.transpose() * scale.asDiagonal();
  for (auto& g : result.score) g = result.inverse * g;
  return result;
}

HandEyeNormal white_part(const Influences& of) {
  HandEyeNormal sum = HandEyeNormal::Zero();
  for (const auto& g : of.score) sum += g * g.transpose();
  return sum;
}

// What lagged products of the influences add to the white part. Correlation time: the influences, in units of
// their own scatter, until neighbours agree no more.
HandEyeNormal lagged_part(const Influences& of, const HandEyeNormal& white, double& correlation_time_s) {
  const HandEyeUnknowns unit = white.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const std::size_t n = of.score.size(), most = n / 8;
  std::size_t length = 0;
  while (length < most) {
    double rho = 0.0;
    for (std::size_t i = 0; i + length + 1 < n; ++i)
      rho += unit.cwiseProduct(of.score[i]).dot(unit.cwiseProduct(of.score[i + length + 1]));
    ++length;
    if (rho / kHandEyeUnknowns < 0.1) break;
  }
  correlation_time_s =
      n > 1 && length > 1
          ? static_cast<double>(length) * (of.time_s.back() - of.time_s.front()) / static_cast<double>(n - 1)
          : 0.0;
  HandEyeNormal sum = HandEyeNormal::Zero();
  const std::size_t reach = length > 1 ? std::min(2 * length, n / 4) : 0;
  for (std::size_t lag = 1; lag <= reach; ++lag) {
    const double bartlett = 1.0 - static_cast<double>(lag) / static_cast<double>(reach + 1);
    for (std::size_t i = 0; i + lag < n; ++i) {
      const HandEyeNormal product = of.score[i] * of.score[i + lag].transpose();
      sum += bartlett * (product + product.transpose());
    }
  }
  return sum;
}

// World axes to the whitened residual's at hand pose `at`.
Eigen::MatrixXd world_axes(const HandEyeProblem& problem, const HandEyeState& x, const HandAt& at) {
  const Matrix3 to_camera = (at.R * x.Rx).conjugate().toRotationMatrix();
  Matrix6 turn = Matrix6::Zero();
  turn.block<3, 3>(0, 0) = turn.block<3, 3>(3, 3) = to_camera;
  return problem.whiten * turn;
}

noise::SmoothError field_part(const HandEyeProblem& problem, const HandEyeState& x, const Influences& of) {
  const bool free_delay = problem.free_delay;
  const std::size_t n = of.score.size(), size = (n + kHandEyeGroups - 1) / kHandEyeGroups;
  const std::size_t groups = (n + size - 1) / size;
  const auto rows = static_cast<Eigen::Index>(groups);
  const Eigen::Index unknowns = free_delay ? kHandEyeUnknowns : kHandEyeUnknowns - 1;
  noise::PoseErrors errors;
  errors.residual = Eigen::MatrixXd::Zero(rows, 6);
  errors.white = Eigen::VectorXd::Zero(rows);
  errors.jacobian.assign(6, Eigen::MatrixXd::Zero(rows, unknowns));
  errors.influence.assign(6, Eigen::MatrixXd::Zero(kHandEyeUnknowns, rows));
  for (std::size_t g = 0; g < groups; ++g) {
    const auto row = static_cast<Eigen::Index>(g);
    const std::size_t first = g * size, last = std::min(n, first + size), middle = (first + last) / 2;
    errors.place.push_back(of.hand[middle].t);
    errors.turn.push_back(of.hand[middle].R);
    errors.axes.push_back(world_axes(problem, x, of.hand[middle]));
    double total = 0.0;
    for (std::size_t i = first; i < last; ++i) total += of.weight[i];
    errors.white[row] = 1.0 / total;
    for (std::size_t i = first; i < last; ++i) {
      const double w = of.weight[i] / total;
      errors.residual.row(row) += w * of.residual[i].transpose();
      for (Eigen::Index c = 0; c < 6; ++c) {
        const auto J = of.weighted[i].row(c);
        errors.jacobian[static_cast<std::size_t>(c)].row(row) += w * J.head(unknowns);
        errors.influence[static_cast<std::size_t>(c)].col(row) += of.weight[i] * (of.inverse * J.transpose());
      }
    }
  }
  return noise::smooth_error(errors);
}

}  // namespace

HandEyeCovariance hand_eye_covariance(const HandEyeProblem& problem, const HandEyeState& x) {
  const Influences of = influences_of(problem, x);
  HandEyeCovariance result;
  result.condition = of.condition;
  const HandEyeNormal white = white_part(of);
  const HandEyeNormal lagged = white + lagged_part(of, white, result.correlation_time_s);
  const auto field = field_part(problem, x, of);
  result.field_length = field.length;
  result.total = white + field.covariance;
  const int free = problem.free_delay ? kHandEyeUnknowns : kHandEyeUnknowns - 1;
  const auto ratio = [&](const HandEyeNormal& a, const HandEyeNormal& b) {
    return a.diagonal().head(free).cwiseQuotient(b.diagonal().head(free).cwiseMax(1e-300)).mean();
  };
  result.total *= std::max(1.0, ratio(lagged, result.total));
  result.grown_by = std::sqrt(std::max(1.0, ratio(result.total, white)));
  const double observations = 6.0 * static_cast<double>(of.score.size());
  result.total *= observations / std::max(observations - kHandEyeUnknowns, 1.0);
  if (problem.free_delay) result.total(12, 12) += kClockOffset * kClockOffset;
  return result;
}

}  // namespace palpate::calibration
