// The decompositions the estimators need, compiled once.
//
// Eigen builds each decomposition anew for every size and every file that names one, at ten seconds of
// compiler time apiece; behind these functions it is built once, for any size. Sizes are those of the
// arguments; a mismatch is a mistake of the caller and asserts. Pure functions, no thread rule. They
// allocate: not for the haptic loop.
#pragma once

#include <Eigen/Core>

namespace palpate::inline math {

using ConstMatrixRef = Eigen::Ref<const Eigen::MatrixXd>;
using ConstVectorRef = Eigen::Ref<const Eigen::VectorXd>;

// J^T J.
Eigen::MatrixXd gram(const ConstMatrixRef& J);

// A x = b for a symmetric, positive semidefinite A (L D L^T, pivoted); a singular direction gets no part of
// x.
Eigen::VectorXd solve_symmetric(const ConstMatrixRef& A, const ConstVectorRef& b);
Eigen::MatrixXd solve_symmetric_columns(const ConstMatrixRef& A, const ConstMatrixRef& B);
Eigen::MatrixXd inverse_symmetric(const ConstMatrixRef& A);
Eigen::MatrixXd pseudo_inverse_symmetric(const ConstMatrixRef& A);

// The covariance of estimates with this information (A^-1, A symmetric and positive semidefinite), scaled by
// A's diagonal first, as the entries of a calibration differ by many orders of magnitude. Never a negative
// variance: what the data do not tell, to the last digit, comes out enormous and not zero. A parameter
// without any information (a zero diagonal) counts as held fixed: variance 0.
Eigen::MatrixXd covariance_from_information(const ConstMatrixRef& A);
// A^-1 M A^-1 in the same way: the covariance where the errors are not those that A was weighed for (Huber
// 1967). M symmetric and positive semidefinite.
Eigen::MatrixXd sandwich_covariance(const ConstMatrixRef& A, const ConstMatrixRef& M);

// A = V diag(values) V^T for a symmetric A; values rise.
struct SymmetricEigen {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
SymmetricEigen symmetric_eigen(const ConstMatrixRef& A);
Eigen::VectorXd symmetric_eigenvalues(const ConstMatrixRef& A);

// X of least |A x - b| for each column b of B (Householder QR with column pivots).
Eigen::MatrixXd least_squares_columns(const ConstMatrixRef& A, const ConstMatrixRef& B);

// Lower L with L L^T = A, and whether A was positive definite at all.
bool lower_cholesky(const ConstMatrixRef& A, Eigen::MatrixXd& L);

// W with W^T W = C^-1: errors of covariance C become independent, of variance 1. False: C is not positive
// definite.
bool whitening(const Eigen::Matrix3d& C, Eigen::Matrix3d& W);

// The rotation R of largest trace(R^T M) (Kabsch 1976; sign by Umeyama 1991): of all rotations the nearest to
// M, and with M = sum of b a^T the one that turns the a onto the b best.
struct NearestRotation {
  Eigen::Matrix3d rotation;
  Eigen::Vector3d values;  // singular values of M, falling
  bool mirrored = false;   // the nearest orthogonal matrix is a reflection: the weakest axis was flipped
};
NearestRotation nearest_rotation(const Eigen::Matrix3d& M);

}  // namespace palpate::inline math
