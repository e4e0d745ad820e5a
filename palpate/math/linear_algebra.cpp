#include "palpate/math/linear_algebra.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>
#include <limits>

namespace palpate::inline math {

using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// B with B B^T = A^-1, so that every variance made of it is a sum of squares.
MatrixXd inverse_root(const ConstMatrixRef& A) {
  VectorXd scale = VectorXd::Zero(A.rows());
  for (Eigen::Index i = 0; i < A.rows(); ++i)
    if (A(i, i) > 0.0) scale[i] = 1.0 / std::sqrt(A(i, i));
  const MatrixXd scaled = scale.asDiagonal() * A * scale.asDiagonal();
  const double least = static_cast<double>(A.rows()) * std::numeric_limits<double>::epsilon();
  const Eigen::LLT<MatrixXd> llt(scaled);
  if (llt.info() == Eigen::Success && llt.matrixLLT().diagonal().minCoeff() > std::sqrt(least))
    return scale.asDiagonal() * MatrixXd(llt.matrixU().solve(MatrixXd::Identity(A.rows(), A.cols())));
  const auto eigen = symmetric_eigen(scaled);
  return scale.asDiagonal() * eigen.vectors *
         eigen.values.cwiseMax(least).cwiseSqrt().cwiseInverse().asDiagonal();
}

}  // namespace

MatrixXd gram(const ConstMatrixRef& J) {
  MatrixXd G = MatrixXd::Zero(J.cols(), J.cols());
  G.selfadjointView<Eigen::Lower>().rankUpdate(J.transpose());
  G.triangularView<Eigen::StrictlyUpper>() = G.transpose();
  return G;
}

VectorXd solve_symmetric(const ConstMatrixRef& A, const ConstVectorRef& b) {
  return Eigen::LDLT<MatrixXd>(A).solve(b);
}

MatrixXd solve_symmetric_columns(const ConstMatrixRef& A, const ConstMatrixRef& B) {
  return Eigen::LDLT<MatrixXd>(A).solve(B);
}

MatrixXd inverse_symmetric(const ConstMatrixRef& A) {
  return solve_symmetric_columns(A, MatrixXd::Identity(A.rows(), A.cols()));
}

MatrixXd pseudo_inverse_symmetric(const ConstMatrixRef& A) {
  const auto eigen = symmetric_eigen(A);
  const double least = static_cast<double>(A.rows()) * std::numeric_limits<double>::epsilon() *
                       eigen.values.cwiseAbs().maxCoeff();
  VectorXd inverse = VectorXd::Zero(A.rows());
  for (Eigen::Index i = 0; i < A.rows(); ++i)
    if (std::abs(eigen.values[i]) > least) inverse[i] = 1.0 / eigen.values[i];
  return eigen.vectors * inverse.asDiagonal() * eigen.vectors.transpose();
}

MatrixXd covariance_from_information(const ConstMatrixRef& A) {
  const MatrixXd B = inverse_root(A);
  return B * B.transpose();
}

MatrixXd sandwich_covariance(const ConstMatrixRef& A, const ConstMatrixRef& M) {
  const MatrixXd B = inverse_root(A);
  const auto eigen = symmetric_eigen(B.transpose() * M * B);
  const MatrixXd C = B * eigen.vectors * eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
  return C * C.transpose();
}

SymmetricEigen symmetric_eigen(const ConstMatrixRef& A) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

VectorXd symmetric_eigenvalues(const ConstMatrixRef& A) {
  return Eigen::SelfAdjointEigenSolver<MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

MatrixXd least_squares_columns(const ConstMatrixRef& A, const ConstMatrixRef& B) {
  return Eigen::ColPivHouseholderQR<MatrixXd>(A).solve(B);
}

bool lower_cholesky(const ConstMatrixRef& A, MatrixXd& L) {
  const Eigen::LLT<MatrixXd> llt(A);
  L = llt.matrixL();
  return llt.info() == Eigen::Success;
}

bool whitening(const Eigen::Matrix3d& C, Eigen::Matrix3d& W) {
  const Eigen::LLT<Eigen::Matrix3d> llt(C);
  W = llt.matrixL().solve(Eigen::Matrix3d::Identity());
  return llt.info() == Eigen::Success;
}

NearestRotation nearest_rotation(const Eigen::Matrix3d& M) {
  // One-sided Jacobi: accurate to the last digit, and for equal singular values too.
  const Eigen::JacobiSVD<MatrixXd> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d U = svd.matrixU(), V = svd.matrixV();
  NearestRotation result;
  result.values = svd.singularValues();
  result.mirrored = (U * V.transpose()).determinant() < 0.0;
  result.rotation = U * Eigen::Vector3d(1.0, 1.0, result.mirrored ? -1.0 : 1.0).asDiagonal() * V.transpose();
  return result;
}

}  // namespace palpate::inline math
