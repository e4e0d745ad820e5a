// A tip pressed into a small block: that what is found is an equilibrium, and how it is come by.
#include "palpate/physics/deformable/equilibrium.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "palpate/core/random.h"
#include "palpate/physics/deformable/box_mesh.h"
#include "palpate/physics/deformable/press_path.h"

namespace palpate::physics::deformable {
namespace {

constexpr double kContactStiffness = 5e9;  // Pa/m

struct PressedBlock {
  explicit PressedBlock(Model model)
      : mesh(*box_mesh(settings())),
        motion(mesh),
        solid(mesh, {}, model),
        contact(mesh, facets_near(mesh, {}, 0.006), kContactStiffness) {
    for (const int node : nodes_on_plane(mesh, 2, -0.02)) motion.hold(node);
    motion.number();
  }
  static BoxMeshSettings settings() {
    BoxMeshSettings settings;
    settings.size = {0.04, 0.04, 0.02};
    settings.core = settings.core_depth = 0.006;
    settings.cells = settings.cells_down = 2;
    settings.shells = 2;
    return settings;
  }
  static RigidTip tip_at(double depth) { return {{0.0, 0.0, 0.008 - depth}, {0.0, 0.0, 1.0}, 0.008}; }
  Eigen::VectorXd at_rest() const {
    return Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * mesh.nodes.size()));
  }
  double energy(const RigidTip& tip, const Eigen::VectorXd& u) const {
    return solid.energy(u) + contact.energy(tip, u);
  }
  // What is left over of the forces on free components, in parts of those of contact.
  double rest(const RigidTip& tip, const Eigen::VectorXd& u) const {
    Eigen::VectorXd pushes = at_rest();
    contact.add_forces(tip, u, pushes);
    return motion.free_part(solid.forces(u) + pushes).norm() / motion.free_part(pushes).norm();
  }

  TetMesh mesh;
  FreeMotion motion;
  Solid solid;
  TipContact contact;
};

TEST(Equilibrium, ForcesAreBalancedAsFarAsIsAskedForAndTheEnergyIsLeast) {
  Random random(1, "equilibrium/other states");
  for (const Model model : {Model::linear, Model::neo_hookean})
    for (const double tolerance : {1e-4, 1e-7}) {
      const PressedBlock block(model);
      auto equilibrium = Equilibrium::prepare(block.mesh, block.solid, block.contact, block.motion);
      ASSERT_TRUE(equilibrium) << equilibrium.error().message;
      const RigidTip tip = PressedBlock::tip_at(0.002);
      Eigen::VectorXd u = block.at_rest();
      const auto steps = equilibrium->solve(tip, {.tolerance = tolerance}, u);
      ASSERT_TRUE(steps) << steps.error().message;
      EXPECT_LE(block.rest(tip, u), tolerance);
      Eigen::VectorXd way = block.at_rest();
      for (double& value : way) value = random.uniform(-1e-6, 1e-6);
      Eigen::VectorXd other = u;
      block.motion.add(block.motion.free_part(way), 1.0, other);
      EXPECT_GT(block.energy(tip, other), block.energy(tip, u));
    }
}

// The matter is linear and the contact is solved exactly: the first step is the last one.
TEST(Equilibrium, ALinearBodyTakesOneFactorisationAndOneStepForAnyDepth) {
  const PressedBlock block(Model::linear);
  auto equilibrium = Equilibrium::prepare(block.mesh, block.solid, block.contact, block.motion);
  ASSERT_TRUE(equilibrium) << equilibrium.error().message;
  Eigen::VectorXd u = block.at_rest();
  for (const double depth : {0.001, 0.003, 0.0005}) {
    const auto steps = equilibrium->solve(PressedBlock::tip_at(depth), {}, u);
    ASSERT_TRUE(steps) << steps.error().message;
    EXPECT_EQ(*steps, 1) << depth;
  }
  EXPECT_EQ(equilibrium->factorisations(), 1);
}

TEST(PressPath, TheTipMayTouchFacetsThatFaceItAndAreNear) {
  BoxMeshSettings settings = PressedBlock::settings();
  settings.size.z() = 0.003;
  settings.core_depth = 0.0015;
  const auto plate = *box_mesh(settings);
  const double reach = 0.006;
  std::vector<int> expected;
  for (const int f : facets_on_plane(plate, 2, 0.0)) {
    const auto& facet = plate.facets[static_cast<std::size_t>(f)];
    if (std::any_of(facet.begin(), facet.end(), [&](int node) {
          return (plate.nodes[static_cast<std::size_t>(node)] - Vector3(0.004, 0.0, 0.0)).norm() < reach;
        }))
      expected.push_back(f);
  }
  EXPECT_GT(expected.size(), 10u);
  EXPECT_EQ(facets_near(plate, {{0.004, 0.0, 0.0}, {0.0, 0.0, 1.0}}, reach), expected);
}

}  // namespace
}  // namespace palpate::physics::deformable
