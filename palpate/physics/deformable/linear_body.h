// Small-strain equilibrium of a body for many loads: its stiffness, factorised once; and what inclusions change of the
// answers, without solving the changed body anew.
//
// With K the stiffness without and K + D with inclusions, D not zero among a few equations only,
//   (K + D)^-1 f = K^-1 f - Z S g,   g = Z' f,   Z = K^-1 at those equations,   S = (1 + D C)^-1 D,   C = Z there
// (Woodbury). So inclusions cost a column of K^-1 for each equation of the elements they touch. Both bodies have one
// mesh, and most of its error cancels in the difference. SI. One thread at a time; it allocates.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/physics/deformable/solid.h"

namespace palpate::physics::deformable {

// Of the undeformed body, linear matter.
SymmetricMatrix linear_stiffness(const TetMesh& mesh, const Material& material, const FreeMotion& motion);
Expected<SparseFactor> factorised(const SymmetricMatrix& matrix);

class InclusionChange {
 public:
  // Both matrices of one mesh and motion, the factor that of `bare`; `rows`: the equations that loads act on and
  // displacements are asked for at. Refused: what a solution is refused for, a body that inclusions make unstable.
  static Expected<InclusionChange> prepare(const SymmetricMatrix& bare, const SymmetricMatrix& with,
                                           const SparseFactor& factor, const std::vector<int>& rows);

  // Equations whose matter changes; none where inclusions touch no element.
  Eigen::Index count() const { return change_.rows(); }
  // Displacements of these in the bare body under a load, given at the rows; a load at few of them is quick.
  Eigen::VectorXd within(const Eigen::VectorXd& load) const;
  // By which the work-conjugate displacement f.u of that load changes.
  double of_answer(const Eigen::VectorXd& within) const { return -within.dot(change_ * within); }
  // By which displacements at the rows change; a column for each load.
  Eigen::MatrixXf of_displacements(const Eigen::MatrixXd& within) const;

 private:
  Eigen::MatrixXd columns_;  // of Z its rows, a column each
  Eigen::MatrixXd change_;   // S
};

}  // namespace palpate::physics::deformable
