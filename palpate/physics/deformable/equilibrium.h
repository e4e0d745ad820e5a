// The state of a body that a rigid tip holds pressed: least energy of matter and contact together.
//
// Matter is linearised and condensed onto the nodes that can be touched (Schur's complement); there, in a small dense system, contact is
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
  Equilibrium(const Solid& solid, const TipContact& contact, const FreeMotion& motion, FreeMotion touched,
              SymmetricMatrix matrix, SymmetricMatrix contact_matrix, SparseFactor factor);
  // Matter's stiffness at u, condensed. Squeezed matter may be unstable where no contact holds it, so
  // a share of the contact's stiffness is put in before it is factorised and taken out of the condensed one.
  Expected<void> linearise(const RigidTip& tip, const Eigen::VectorXd& u);
  Expected<void> condense();
  // Matter's forces that are left over are `forces`: the way to where the linearised matter and the contact are in
  // equilibrium, all components.
  Expected<Eigen::VectorXd> way(const RigidTip& tip, const Eigen::VectorXd& u, const Eigen::VectorXd& forces);
  // The displacements y of the touched components with the least of y' condensed_ y / 2 + pull' y + contact.
  Eigen::VectorXd touch(const RigidTip& tip, const Eigen::VectorXd& u, const Eigen::VectorXd& pull);
  // The contact's second derivatives there are added to `dense`.
  void add_contact(const RigidTip& tip, const Eigen::VectorXd& u, bool curved, double share,
                   Eigen::MatrixXd& dense);
  Expected<void> search(const RigidTip& tip, const Eigen::VectorXd& way, Eigen::VectorXd& u) const;

  const Solid* solid_;
  const TipContact* contact_;
  const FreeMotion* motion_;
  FreeMotion touched_;  // of what is free, what can be touched
  SymmetricMatrix matrix_;
  SymmetricMatrix contact_matrix_;
  SparseFactor factor_;
  // Of the touched components, the others in equilibrium: the stiffness, what was put in and taken out, and the sum.
  Eigen::MatrixXd condensed_, held_, factorised_;
  int factorisations_ = 0;
};

}  // namespace palpate::physics::deformable
