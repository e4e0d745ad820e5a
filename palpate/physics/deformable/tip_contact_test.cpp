#include "palpate/physics/deformable/tip_contact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "palpate/core/random.h"
#include "palpate/physics/deformable/block.h"
#include "palpate/physics/deformable/equilibrium.h"
#include "palpate/physics/deformable/half_space.h"
#include "palpate/physics/deformable/press_path.h"

namespace palpate::physics::deformable {
namespace {

constexpr double kRadius = 0.005;

// A half of it is meshed: the tip may go along x.
Indentation soft_block(double fineness) {
  Indentation it;
  it.material.matrix = {6000.0, 0.45};
  it.material.inclusions = {{{0.01, 0.0, -0.02}, Vector3::Constant(0.002), 1.0}};  // as the rest is
  it.size = {0.1, 0.1, 0.05};
  it.radius = kRadius;
  it.model = Model::linear;
  it.fineness = fineness;
  return it;
}

RigidTip tip_at(double aside, double depth) {
  return {{aside, 0.0, kRadius - depth}, {0.0, 0.0, 1.0}, kRadius};
}

// A tip on a block of linear matter, moved step by step.
struct Rubbing {
  Indentation it;
  Block block;
  Solid solid;
  TipContact contact;
  Equilibrium equilibrium;
  Eigen::VectorXd u;

  Rubbing(const Indentation& pressed, double widest)
      : it(pressed),
        block(*mesh_block(it, widest)),
        solid(block.mesh, it.material, it.model),
        contact(block.mesh, facets_near(block.mesh, {}, 1.6 * widest),
                5000.0 * it.material.matrix.young / kRadius),
        equilibrium(*Equilibrium::prepare(block.mesh, solid, contact, block.motion)),
        u(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * block.mesh.nodes.size()))) {}

  // Of the whole block on the tip.
  Vector3 go(const RigidTip& from, const RigidTip& to, bool rubs) {
    contact.hold(from, u);
    if (rubs) contact.weigh(to, u);
    for (int k = 0; k < 4; ++k) {
      EXPECT_TRUE(equilibrium.solve(to, {.tolerance = 1e-6}, u));
      if (!rubs) break;
      contact.weigh(to, u);
    }
    return block.copies * contact.state(to, u).force;
  }
};

TEST(TipContact, ForcesAndStiffnessAreTheEnergysDerivatives) {
  Rubbing r(soft_block(2.0), 0.002);
  r.contact.set_friction(0.7, 1e-5);
  Random random(3, "test/tip contact");
  const auto draw = [&](double scale) {
    Eigen::VectorXd v(r.u.size());
    for (auto& x : v) x = random.normal(scale);
    return v;
  };
  r.u = draw(1e-6);
  const RigidTip before = tip_at(0.0, 0.0006);
  r.contact.hold(before, r.u);
  ASSERT_GT(r.contact.weigh(before, r.u), 0.0);
  FreeMotion motion(r.block.mesh);
  motion.number();
  for (const double aside : {2e-6, 2e-4}) {  // held, and sliding
    const RigidTip tip = tip_at(aside, 0.0007);
    const Eigen::VectorXd way = draw(1.0).normalized();
    constexpr double kStep = 2e-8;
    const auto forces_at = [&](const Eigen::VectorXd& at) {
      Eigen::VectorXd forces = Eigen::VectorXd::Zero(at.size());
      r.contact.add_forces(tip, at, forces);
      return forces;
    };
    const Eigen::VectorXd ahead = r.u + kStep * way, behind = r.u - kStep * way;
    const double slope = forces_at(r.u).dot(way);
    EXPECT_NEAR(slope, (r.contact.energy(tip, ahead) - r.contact.energy(tip, behind)) / (2 * kStep),
                2e-4 * std::abs(slope));
    auto matrix = stiffness_pattern(r.block.mesh, motion);
    r.contact.add_stiffness(tip, r.u, motion, true, matrix);
    Eigen::VectorXd change = Eigen::VectorXd::Zero(way.size());
    for (int column = 0; column < matrix.size; ++column)
      for (int k = matrix.starts[static_cast<std::size_t>(column)];
           k < matrix.starts[static_cast<std::size_t>(column) + 1]; ++k) {
        const int row = matrix.rows[static_cast<std::size_t>(k)];
        const double value = matrix.values[static_cast<std::size_t>(k)];
        change[row] += value * way[column];
        if (row != column) change[column] += value * way[row];
      }
    const Eigen::VectorXd expected = (forces_at(ahead) - forces_at(behind)) / (2 * kStep);
    EXPECT_LT((change - expected).norm(), 2e-3 * expected.norm()) << aside;
  }
}

// Cattaneo (1938), Mindlin (1949): pressed with P first, then drawn aside by x, the outer ring slips and the force is
// mu P (1 - (1 - x/x_m)^(3/2)), x_m = 3 mu P (2 - nu)/(16 G a); from x_m on everything slides.
TEST(TipContact, DrawnAsideItHoldsAndSlipsAsMindlinSays) {
  constexpr double kFriction = 0.3, kDepth = 0.05 * kRadius;
  const double a = hertz_contact_radius(kRadius, kDepth);
  const auto it = soft_block(3.0);
  Rubbing r(it, a);
  RigidTip at = tip_at(0.0, kDepth);
  const double pressed = r.go(tip_at(0.0, 0.0), at, false).z();
  EXPECT_NEAR(pressed / hertz_force(it.material.matrix, kRadius, kDepth), 1.0, 0.05);
  r.contact.set_friction(kFriction, 1e-5 * kRadius);
  const double nu = it.material.matrix.poisson, shear = it.material.matrix.young / (2.0 * (1.0 + nu));
  const double slides = 3.0 * kFriction * pressed * (2.0 - nu) / (16.0 * shear * a);
  for (const double share : {0.3, 0.7, 1.3}) {
    const RigidTip next = tip_at(share * slides, kDepth);
    const Vector3 force = r.go(at, next, true);
    at = next;
    const double expected = 1.0 - std::pow(std::max(0.0, 1.0 - share), 1.5);
    EXPECT_NEAR(-force.x() / (kFriction * pressed), expected, 0.02) << share;
  }
}

// Mossakovskii (1954): pressed a little deeper, a contact that cannot slip is stiffer than one that slips freely by
// (1 - nu) ln(3 - 4 nu)/(1 - 2 nu), a tenth at nu = 0. So shallow that the surface's slope does not count.
TEST(TipContact, WhatCannotSlipIsStifferByMossakovskiisFactor) {
  constexpr double kDepth = 0.001 * kRadius, kMore = 0.02 * kDepth;
  auto it = soft_block(3.0);
  it.material.inclusions.clear();
  it.material.matrix.poisson = 0.0;
  Rubbing r(it, hertz_contact_radius(kRadius, kDepth));
  const RigidTip at = tip_at(0.0, kDepth), deeper = tip_at(0.0, kDepth + kMore);
  const double force = r.go(tip_at(0.0, 0.0), at, false).z();
  const Eigen::VectorXd pressed = r.u;
  const double slipping = r.go(at, deeper, false).z() - force;
  r.u = pressed;
  r.contact.set_friction(5.0, 3e-8 * kRadius);
  const double held = r.go(at, deeper, true).z() - force;
  EXPECT_NEAR(held / slipping, std::log(3.0), 0.02);
}

// On its whole way: what cannot slip inwards makes the contact smaller, which takes back most of it.
TEST(TipContact, FrictionMakesAPressStifferAndBounded) {
  auto it = soft_block(2.0);
  it.material.inclusions.clear();
  it.material.matrix.poisson = 0.0;
  it.depths = {0.1 * kRadius};
  double before = 0.0;
  for (const double friction : {0.0, 0.1, 5.0}) {
    it.friction = friction;
    const auto points = solve_indentation(it);
    ASSERT_TRUE(points) << points.error().message;
    EXPECT_GT((*points)[0].force, 1.0005 * before) << friction;
    if (before > 0.0) {
      EXPECT_LT((*points)[0].force, 1.03 * before) << friction;
    }
    before = (*points)[0].force;
  }
}

}  // namespace
}  // namespace palpate::physics::deformable
