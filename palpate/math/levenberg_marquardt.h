// Nonlinear least squares by Levenberg-Marquardt on the normal equations: for problems of a few to a few dozen
// unknowns that are solved by the thousand.
//
// The cost is the sum of r(x)^2, or of a robust loss of it (robust_loss.h). Damping follows Marquardt's
// scaling (lambda times the diagonal of J^T J), so that the path does not depend on the units of the unknowns,
// and Nielsen's rule for lambda. The state may be anything that a step moves: a vector, a pose, a lens with
// places. Deterministic; pure but for the caller's functions; no thread rule. Not for the haptic loop: beyond 16
// unknowns it allocates.
//
// Converged: the last step changed the residuals by less than `tolerance` of their length, or no step lowers
// the cost any more. Not converged: the iterations were used up, or an equation is not finite; the state is
// then the best one found.
//
// Sources: Marquardt (1963), "An algorithm for least-squares estimation of nonlinear parameters"; Nielsen
// (1999), "Damping parameter in Marquardt's method"; Madsen, Nielsen, Tingleff (2004), section 3.2.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <utility>

#include "palpate/math/linear_algebra.h"
#include "palpate/math/robust_loss.h"

namespace palpate::inline math {

struct LeastSquaresOptions {
  int most_iterations = 100;
  double tolerance = 1e-10;
  double first_damping = 1e-6;
};

struct LeastSquaresResult {
  double cost = 0.0;
  int iterations = 0;
  bool converged = false;
};

// What the linear model says of a step: by how much the cost falls, and by how much the residuals change (the
// step's length in columns of unit length). Not finite: there is no step.
struct StepModel {
  double predicted = 0.0;
  double length = 0.0;
};

template <typename Step>
struct DampedStep {
  Step step;
  StepModel model;
};

// (J^T J + damping diag(J^T J)) step = -J^T r; the lower triangle is read. An unknown that nothing depends on
// stays where it is.
StepModel solve_damped(const ConstMatrixRef& JtJ, const ConstVectorRef& Jtr, double damping,
                       Eigen::Ref<Eigen::VectorXd> step);

// N unknowns, or Eigen::Dynamic.
template <int N>
struct NormalEquations {
  using Step = Eigen::Matrix<double, N, 1>;

  Eigen::Matrix<double, N, N> JtJ;  // the lower triangle is read
  Step Jtr;

  explicit NormalEquations(Eigen::Index unknowns = N == Eigen::Dynamic ? 0 : N) { set_zero(unknowns); }
  void set_zero(Eigen::Index unknowns) {
    JtJ.setZero(unknowns, unknowns);
    Jtr.setZero(unknowns);
  }
  Eigen::Index unknowns() const { return Jtr.size(); }

  // Residuals r with derivatives J (rows of r by unknowns), each square weighed by `weight`.
  template <typename Jacobian, typename Residual>
  void add(const Eigen::MatrixBase<Jacobian>& J, const Eigen::MatrixBase<Residual>& r, double weight = 1.0) {
    JtJ.noalias() += weight * (J.transpose() * J);
    Jtr.noalias() += weight * (J.transpose() * r);
  }

  DampedStep<Step> solve(double damping) const {
    DampedStep<Step> found{Step(Jtr.size()), {}};
    found.model = solve_damped(JtJ, Jtr, damping, found.step);
    return found;
  }
};

// What is done with the steps, apart from the problem's type: Nielsen's damping and the rules of the end.
class Descent {
 public:
  Descent(double cost, const LeastSquaresOptions& options);

  bool begin_iteration();  // false: it is over
  double damping() const { return damping_; }
  // Most steps are good: the equations there come with the cost, and only after a bad one is asked first.
  bool hopeful() const { return hopeful_; }

  enum class Verdict { no_step, last_step, try_it };
  Verdict judge_step(const StepModel& model);
  // Of a step that was tried; whether it is taken. The next iteration needs the equations there.
  bool takes(double cost, const StepModel& model);

  const LeastSquaresResult& result() const { return result_; }

 private:
  LeastSquaresOptions options_;
  LeastSquaresResult result_;
  double damping_, growth_ = 2.0;
  int blind_steps_ = 0;
  bool hopeful_ = true, over_ = false;
};

// From x on. `evaluate(x, equations)` gives the cost, and the equations too where the pointer is not null; it
// finds them as they are left, and a cost that is not finite refuses the step. `moved(x, step)` gives the state
// a step away. `at` are equations of the size they need. Equations other than NormalEquations (with frames
// eliminated, say) have a Step and a solve() of their own.
template <typename Equations, typename State, typename Evaluate, typename Moved>
LeastSquaresResult minimise_with(Equations at, State& x, const Evaluate& evaluate, const Moved& moved,
                                 const LeastSquaresOptions& options = {}) {
  Equations ahead = at;
  Descent descent(evaluate(x, &at), options);
  bool stale = false;
  while (descent.begin_iteration()) {
    if (stale) evaluate(x, &at);
    stale = false;
    const auto found = at.solve(descent.damping());
    const auto verdict = descent.judge_step(found.model);
    if (verdict == Descent::Verdict::no_step) break;
    State next = moved(x, found.step);
    if (verdict == Descent::Verdict::last_step) {
      x = std::move(next);
      break;
    }
    const bool hopeful = descent.hopeful();
    const double cost = evaluate(next, hopeful ? &ahead : nullptr);
    if (!descent.takes(cost, found.model)) continue;
    x = std::move(next);
    if (hopeful) std::swap(at, ahead);
    stale = !hopeful;
  }
  return descent.result();
}

// With N unknowns.
template <int N, typename State, typename Evaluate, typename Moved>
LeastSquaresResult minimise(State& x, const Evaluate& evaluate, const Moved& moved,
                            const LeastSquaresOptions& options = {}) {
  static_assert(N != Eigen::Dynamic, "equations of a size that is known at run time go to minimise_with()");
  const auto from_zero = [&](const State& at, NormalEquations<N>* equations) {
    if (equations) equations->set_zero(N);
    return evaluate(at, equations);
  };
  return minimise_with(NormalEquations<N>(), x, from_zero, moved, options);
}

// Of a vector, of fixed size or not.
template <int N, typename Evaluate>
LeastSquaresResult minimise(Eigen::Matrix<double, N, 1>& x, const Evaluate& evaluate,
                            const LeastSquaresOptions& options = {}) {
  using Vector = Eigen::Matrix<double, N, 1>;
  const auto from_zero = [&](const Vector& at, NormalEquations<N>* equations) {
    if (equations) equations->set_zero(at.size());
    return evaluate(at, equations);
  };
  const auto moved = [](const Vector& at, const Vector& step) -> Vector { return at + step; };
  return minimise_with(NormalEquations<N>(x.size()), x, from_zero, moved, options);
}

}  // namespace palpate::inline math
