// The state of a body that a rigid tip holds pressed: least energy of matter and contact together.
//
// Matter is linearised and condensed onto the nodes that can be touched; there, in a small dense system, contact is
// solved exactly (Newton, line search); the step is then searched along the true energy. Factor and condensation are
// kept as long as steps with them converge, and a linear body needs one only. SI. One thread at a time; it allocates.
// Refused: no convergence, no memory.
#pragma once

#include <Eigen/Core>

#include "palpate/physics/deformable/solid.h"
#include "palpate/physics/deformable/tip_contact.h"

namespace palpate::physics::deformable {

struct NewtonSettings {
  int most_steps = 60;
  double tolerance = 1e-5;  // forces left over, in parts of the forces of contact
};

class Equilibrium {
 public:
  // What it is given must outlive it.
  static Expected<Equilibrium> prepare(const TetMesh& mesh, const Solid& solid, const TipContact& contact,
                                       const FreeMotion& motion);

  // From the displacements u to those of equilibrium. The steps taken.
  Expected<int> solve(const RigidTip& tip, const NewtonSettings& settings, Eigen::VectorXd& u);
  int factorisations() const { return factorisations_; }

 private:
  Equilibrium(const TetMesh& mesh, const Solid& solid, const TipContact& contact, const FreeMotion& motion,
              SymmetricMatrix matrix, SparseFactor factor);
  // Matter's stiffness at u, factorised and condensed.
  Expected<void> linearise(const Eigen::VectorXd& u);
  Expected<void> condense();
  // Matter's forces that are left over are `forces`: the way to where the linearised matter and the contact are in
  // equilibrium, all components.
  Expected<Eigen::VectorXd> way(const RigidTip& tip, const Eigen::VectorXd& u, const Eigen::VectorXd& forces);
  // Displacements y of the touched components, with stiffness condensed_ about y0 and the contact.
  Expected<Eigen::VectorXd> touch(const RigidTip& tip, const Eigen::VectorXd& u, const Eigen::VectorXd& y0);
  Expected<void> search(const RigidTip& tip, const Eigen::VectorXd& way, Eigen::VectorXd& u) const;

  const Solid* solid_;
  const TipContact* contact_;
  const FreeMotion* motion_;
  FreeMotion touched_;  // of what is free, what can be touched
  SymmetricMatrix matrix_;
  SymmetricMatrix contact_matrix_;
  SparseFactor factor_;
  Eigen::MatrixXd condensed_;  // stiffness of the touched components, the others in equilibrium
  int factorisations_ = 0;
};

}  // namespace palpate::physics::deformable
