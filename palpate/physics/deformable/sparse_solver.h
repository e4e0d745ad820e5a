// Sparse symmetric positive definite systems: factorised once, solved for many right-hand sides.
//
// The library that does it (MUMPS, multifrontal; Amestoy et al., SIAM J. Matrix Anal. Appl. 23, 2001) stays behind
// this header. Any units. One thread at a time for each factor;
// factors in several threads wait for each other. It allocates: not for the haptic loop.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "palpate/core/expected.h"

namespace palpate::physics::deformable {

// The lower triangle with the diagonal, column by column, rows of a column rising.
struct SymmetricMatrix {
  int size = 0;
  std::vector<int> starts;  // size + 1
  std::vector<int> rows;
  std::vector<double> values;

  // Where entry (row, column) of the lower triangle is kept; -1 where it is not.
  int slot(int row, int column) const;
  Eigen::VectorXd times(const Eigen::VectorXd& x) const;
};

class SparseFactor {
 public:
  // The order of elimination for this pattern; the equations `kept` are not eliminated. Refused: an index out of
  // range, no memory (exhausted).
  static Expected<SparseFactor> analyse(const SymmetricMatrix& matrix, const std::vector<int>& kept = {});
  ~SparseFactor();
  SparseFactor(SparseFactor&&) noexcept;
  SparseFactor& operator=(SparseFactor&&) noexcept;

  // A matrix of the pattern that was analysed. Refused: singular or not positive definite (of what is kept nothing is
  // known), no memory (exhausted); then there is no factor.
  Expected<void> factorise(const SymmetricMatrix& matrix);
  // The right-hand sides, a column each, become the solutions. Refused where there is no factor, or equations are kept.
  Expected<void> solve(Eigen::MatrixXd& columns) const;
  Expected<void> solve(Eigen::VectorXd& column) const;

  // With k the kept and e the eliminated equations: A_kk - A_ke A_ee^-1 A_ek (Schur's complement), in their order.
  // Empty where nothing is factorised or kept.
  Eigen::MatrixXd condensed() const;
  // The right-hand side that is left for the kept: b_k - A_ke A_ee^-1 b_e.
  Expected<Eigen::VectorXd> condense(const Eigen::VectorXd& right) const;
  // Of the right-hand side condensed last: all unknowns where the kept ones have these values.
  Expected<Eigen::VectorXd> expand(const Eigen::VectorXd& kept) const;

  std::int64_t entries() const;  // of the factor

 private:
  struct Library;
  explicit SparseFactor(std::unique_ptr<Library> library);
  std::unique_ptr<Library> library_;
};

}  // namespace palpate::physics::deformable
