#include "palpate/math/levenberg_marquardt.h"

#include <Eigen/Cholesky>
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

// Up to this many unknowns nothing is allocated.
constexpr int kSmall = 16;
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kSmall, kSmall>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kSmall, 1>;

template <typename Matrix, typename Vector>
StepModel solve_in(const ConstMatrixRef& JtJ, const ConstVectorRef& Jtr, double damping,
                   Eigen::Ref<Eigen::VectorXd> step) {
  const Eigen::Index n = Jtr.size();
  // Columns scaled to unit length: the damping is then lambda on the diagonal, and the solve well scaled.
  Vector scale = JtJ.diagonal().cwiseSqrt();
  const double least = kRounding * scale.maxCoeff();
  for (double& s : scale) s = s > least ? 1.0 / s : 0.0;
  Matrix scaled(n, n);  // the lower triangle is read
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index i = j; i < n; ++i) scaled(i, j) = scale[i] * JtJ(i, j) * scale[j];
    scaled(j, j) += damping;
  }
  const Vector gradient = scale.cwiseProduct(Jtr);
  Vector step_scaled = -gradient;
  Eigen::LDLT<Eigen::Ref<Matrix>> factor(scaled);  // in place: nothing is copied
  factor.solveInPlace(step_scaled);
  step = scale.cwiseProduct(step_scaled);
  if (!step.allFinite()) return {std::numeric_limits<double>::quiet_NaN(), 0.0};
  return {step_scaled.dot(damping * step_scaled - gradient), step_scaled.norm()};
}

}  // namespace

StepModel solve_damped(const ConstMatrixRef& JtJ, const ConstVectorRef& Jtr, double damping,
                       Eigen::Ref<Eigen::VectorXd> step) {
  if (Jtr.size() == 0) return {};
  return Jtr.size() <= kSmall ? solve_in<SmallMatrix, SmallVector>(JtJ, Jtr, damping, step)
                              : solve_in<Eigen::MatrixXd, Eigen::VectorXd>(JtJ, Jtr, damping, step);
}

Descent::Descent(double cost, const LeastSquaresOptions& options)
    : options_(options), result_{cost, 0, false}, damping_(options.first_damping) {}

bool Descent::begin_iteration() {
  if (over_ || result_.iterations >= options_.most_iterations) return false;
  ++result_.iterations;
  return true;
}

Descent::Verdict Descent::judge_step(const StepModel& model) {
  if (!std::isfinite(model.predicted)) return Verdict::no_step;
  if (!(model.length <= options_.tolerance * std::sqrt(std::max(result_.cost, 1e-300))))
    return Verdict::try_it;
  result_.converged = true;
  return Verdict::last_step;
}

bool Descent::takes(double cost, const StepModel& model) {
  const bool rounding = std::abs(result_.cost - cost) <= kSameCost * result_.cost;
  if (std::isfinite(cost) && (cost < result_.cost || rounding) && model.predicted > 0.0) {
    const double gain = rounding ? 1.0 : (result_.cost - cost) / model.predicted;
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
