// Nonlinear least squares by Levenberg-Marquardt on the normal equations: for problems of a few dozen
// unknowns that are solved by the thousand.
//
// The cost is sum r(x)^2. Damping follows Marquardt's scaling (lambda times the diagonal of J^T J), so that
// the path does not depend on the units of the unknowns, and Nielsen's rule for lambda. Deterministic; pure
// but for the caller's functions; no thread rule. Converged: the last step changed the residuals by less than
// `tolerance` of their length, or no step lowers the cost any more. Sources: Marquardt (1963), "An algorithm
// for least-squares estimation of nonlinear parameters"; Nielsen (1999), "Damping parameter in Marquardt's
// method"; Madsen, Nielsen, Tingleff (2004), section 3.2.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace palpate::inline math {

struct NormalEquations {
  Eigen::MatrixXd JtJ;  // the lower triangle is read
  Eigen::VectorXd Jtr;
  double cost = 0.0;  // sum of r^2
};

struct LeastSquaresProblem {
  std::function<double(const Eigen::VectorXd& x)> cost;  // not finite: the step is not taken
  // Fills all of `equations`, which have their sizes and are zero.
  std::function<void(const Eigen::VectorXd& x, NormalEquations& equations)> linearise;
};

struct LeastSquaresOptions {
  int most_iterations = 100;
  double tolerance = 1e-10;
  double first_damping = 1e-6;
};

struct LeastSquaresResult {
  Eigen::VectorXd x;
  double cost = 0.0;
  int iterations = 0;
  bool converged = false;
};

LeastSquaresResult least_squares_from(Eigen::VectorXd start, const LeastSquaresProblem& problem,
                                      const LeastSquaresOptions& options = {});

}  // namespace palpate::inline math
