#include "palpate/math/levenberg_marquardt.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpate/math/linear_algebra.h"

namespace palpate::inline math {
namespace {

// A column this much shorter than the longest is rounding: its unknown stays where it is.
constexpr double kRounding = 1e-12;
// Costs as near as this do not tell which of two places is better. The steps do: each is a thousandth of the
// one before where the model is right, so a few more are taken without looking at the cost.
constexpr double kSameCost = 1e-13;
constexpr int kBlindSteps = 2;
constexpr double kLeastDamping = 1e-14, kMostDamping = 1e12;

}  // namespace

LeastSquaresResult least_squares_from(Eigen::VectorXd start, const LeastSquaresProblem& problem,
                                      const LeastSquaresOptions& options) {
  LeastSquaresResult result{std::move(start), 0.0, 0, false};
  const Eigen::Index n = result.x.size();
  if (n == 0) {
    result.cost = problem.cost(result.x);
    result.converged = true;
    return result;
  }
  NormalEquations at, ahead;
  const auto linearise = [&](const Eigen::VectorXd& x, NormalEquations& equations) {
    equations.JtJ.setZero(n, n);
    equations.Jtr.setZero(n);
    equations.cost = 0.0;
    problem.linearise(x, equations);
    return equations.cost;
  };
  bool stale = true;
  // Most steps are good: the equations there come with the cost, and only after a bad one is asked first.
  bool hopeful = true;
  int blind_steps = 0;
  double damping = options.first_damping, growth = 2.0;
  while (result.iterations < options.most_iterations) {
    ++result.iterations;
    if (stale) result.cost = linearise(result.x, at);
    stale = false;
    // Columns scaled to unit length: the damping is then lambda on the diagonal, and the solve well scaled.
    Eigen::VectorXd scale = at.JtJ.diagonal().cwiseSqrt();
    const double least = kRounding * scale.maxCoeff();
    for (double& s : scale) s = s > least ? 1.0 / s : 0.0;
    Eigen::MatrixXd scaled = at.JtJ.selfadjointView<Eigen::Lower>();
    scaled = scale.asDiagonal() * scaled * scale.asDiagonal();
    const Eigen::VectorXd gradient = scale.cwiseProduct(at.Jtr);
    scaled.diagonal().array() += damping;
    const Eigen::VectorXd step_scaled = solve_symmetric(scaled, -gradient);
    const Eigen::VectorXd step = scale.cwiseProduct(step_scaled);
    if (!step.allFinite()) return result;
    if (step_scaled.norm() <= options.tolerance * std::sqrt(std::max(result.cost, 1e-300))) {
      result.x += step;
      result.converged = true;
      return result;
    }
    const Eigen::VectorXd next = result.x + step;
    const double cost = hopeful ? linearise(next, ahead) : problem.cost(next);
    const double predicted = step_scaled.dot(damping * step_scaled - gradient);
    const bool rounding = std::abs(result.cost - cost) <= kSameCost * result.cost;
    if (std::isfinite(cost) && (cost < result.cost || rounding) && predicted > 0.0) {
      const double gain = rounding ? 1.0 : (result.cost - cost) / predicted;
      result.x = next;
      result.cost = cost;
      stale = !hopeful;
      if (hopeful) std::swap(at, ahead);
      hopeful = true;
      if (rounding && ++blind_steps == kBlindSteps) {
        result.converged = true;
        return result;
      }
      const double cube = 2.0 * gain - 1.0;
      damping = std::max(kLeastDamping, damping * std::max(1.0 / 10.0, 1.0 - cube * cube * cube));
      growth = 2.0;
    } else {
      hopeful = false;
      damping *= growth;
      growth *= 2.0;
      if (damping > kMostDamping) {  // no step lowers the cost: rounding is all that is left
        result.converged = true;
        return result;
      }
    }
  }
  return result;
}

}  // namespace palpate::inline math
