#include "palpate/math/levenberg_marquardt.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

DampedStep<Eigen::VectorXd> solve_damped(const ConstMatrixRef& JtJ, const ConstVectorRef& Jtr,
                                         double damping) {
  // Columns scaled to unit length: the damping is then lambda on the diagonal, and the solve well scaled.
  Eigen::VectorXd scale = JtJ.diagonal().cwiseSqrt();
  if (scale.size() == 0) return {scale};
  const double least = kRounding * scale.maxCoeff();
  for (double& s : scale) s = s > least ? 1.0 / s : 0.0;
  Eigen::MatrixXd scaled = JtJ.selfadjointView<Eigen::Lower>();
  scaled = scale.asDiagonal() * scaled * scale.asDiagonal();
  const Eigen::VectorXd gradient = scale.cwiseProduct(Jtr);
  scaled.diagonal().array() += damping;
  const Eigen::VectorXd step_scaled = solve_symmetric(scaled, -gradient);
  DampedStep<Eigen::VectorXd> result{scale.cwiseProduct(step_scaled)};
  result.predicted = step_scaled.dot(damping * step_scaled - gradient);
  result.length = step_scaled.norm();
  if (!result.step.allFinite()) result.predicted = std::numeric_limits<double>::quiet_NaN();
  return result;
}

Descent::Descent(double cost, const LeastSquaresOptions& options)
    : options_(options), result_{cost, 0, false}, damping_(options.first_damping) {}

bool Descent::begin_iteration() {
  if (over_ || result_.iterations >= options_.most_iterations) return false;
  ++result_.iterations;
  return true;
}

Descent::Verdict Descent::judge_step(double length, bool finite) {
  if (!finite) return Verdict::no_step;
  if (!(length <= options_.tolerance * std::sqrt(std::max(result_.cost, 1e-300)))) return Verdict::try_it;
  result_.converged = true;
  return Verdict::last_step;
}

bool Descent::takes(double cost, double predicted) {
  const bool rounding = std::abs(result_.cost - cost) <= kSameCost * result_.cost;
  if (std::isfinite(cost) && (cost < result_.cost || rounding) && predicted > 0.0) {
    const double gain = rounding ? 1.0 : (result_.cost - cost) / predicted;
    result_.cost = cost;
    hopeful_ = true;
    if (rounding && ++blind_steps_ == kBlindSteps) result_.converged = over_ = true;
    const double cube = 2.0 * gain - 1.0;
    damping_ = std::max(kLeastDamping, damping_ * std::max(1.0 / 10.0, 1.0 - cube * cube * cube));
    growth_ = 2.0;
    return true;
  }
  hopeful_ = false;
  damping_ *= growth_;
  growth_ *= 2.0;
  if (damping_ > kMostDamping) result_.converged = over_ = true;  // rounding is all that is left
  return false;
}

}  // namespace palpate::inline math
