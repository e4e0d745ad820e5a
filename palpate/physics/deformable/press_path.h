// A tip pushed into a body along the normal of one place, from one depth to the next: the full solution, step by step.
//
// Depth is counted from where the tip touches the undeformed place. Each state starts from the one before, carried on
// along its way. SI, the body's frame. One thread; it allocates. Refused: no equilibrium, no memory.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "palpate/core/expected.h"
#include "palpate/physics/deformable/equilibrium.h"
#include "palpate/physics/deformable/solid.h"
#include "palpate/physics/deformable/surface_load.h"
#include "palpate/physics/deformable/tip_contact.h"

namespace palpate::physics::deformable {

class PressPath {
 public:
  // `facets`: those that the tip may touch. Mesh and motion must outlive it.
  static Expected<PressPath> prepare(const TetMesh& mesh, const FreeMotion& motion, const Material& material,
                                     Model model, const std::vector<int>& facets, const SurfaceSite& site,
                                     double radius, double friction = 0.0);
  // Deeper than before.
  Expected<TipContact::State> press(double depth);
  const Eigen::VectorXd& displacements() const { return now_; }

 private:
  PressPath() = default;
  RigidTip tip_at(double depth) const;
  double next_depth(double wanted) const;
  Expected<void> move_to(double depth);
  Expected<void> settle(const RigidTip& tip, Eigen::VectorXd& u);

  std::unique_ptr<Solid> solid_;
  std::unique_ptr<TipContact> contact_;
  std::unique_ptr<Equilibrium> equilibrium_;
  Model model_ = Model::neo_hookean;
  SurfaceSite site_;
  double radius_ = 0.0, friction_ = 0.0;
  Eigen::VectorXd now_, before_;
  double depth_ = 0.0, depth_before_ = 0.0;
};

// Facets that face the site's normal and have a node within `reach` of it.
std::vector<int> facets_near(const TetMesh& mesh, const SurfaceSite& site, double reach);

}  // namespace palpate::physics::deformable
