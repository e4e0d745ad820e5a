// What inclusions change, against the changed body solved by itself.
#include "palpate/physics/deformable/linear_body.h"

#include <gtest/gtest.h>

#include "palpate/physics/deformable/box_mesh.h"
#include "palpate/physics/deformable/surface_load.h"

namespace palpate::physics::deformable {
namespace {

TEST(InclusionChange, IsThatOfTheChangedBodySolvedByItself) {
  BoxMeshSettings settings;
  settings.size = {0.06, 0.06, 0.03};
  settings.core = settings.core_depth = 0.012;
  settings.cells = settings.cells_down = 2;
  settings.shells = 2;
  const auto mesh = box_mesh(settings);
  ASSERT_TRUE(mesh);
  FreeMotion motion(*mesh);
  for (const int node : nodes_on_plane(*mesh, 2, -0.03)) motion.hold(node);
  motion.number();
  // One stiffer, one softer, and beside one another.
  const Material material{{6000.0, 0.45},
                          {{{0.0, 0.0, -0.012}, Vector3::Constant(0.006), 10.0},
                           {{0.013, 0.0, -0.010}, Vector3::Constant(0.005), 0.3}}};
  const auto bare = linear_stiffness(*mesh, {material.matrix, {}}, motion);
  const auto with = linear_stiffness(*mesh, material, motion);
  const auto factor = factorised(bare), changed = factorised(with);
  ASSERT_TRUE(factor);
  ASSERT_TRUE(changed);
  std::vector<int> all(static_cast<std::size_t>(motion.count()));
  for (int e = 0; e < motion.count(); ++e) all[static_cast<std::size_t>(e)] = e;
  const auto change = InclusionChange::prepare(bare, with, *factor, all);
  ASSERT_TRUE(change) << change.error().message;
  EXPECT_GT(change->count(), 0);
  EXPECT_LT(change->count(), motion.count());
  for (const Vector3& place : {Vector3(0.0, 0.0, 0.0), Vector3(0.01, 0.002, 0.0)}) {
    const Eigen::VectorXd load = motion.free_part(hertz_load(*mesh, {place, {0.0, 0.0, 1.0}}, 0.006));
    Eigen::VectorXd before = load, after = load;
    ASSERT_TRUE(factor->solve(before));
    ASSERT_TRUE(changed->solve(after));
    const Eigen::VectorXd within = change->within(load);
    const double is = load.dot(after - before);
    EXPECT_GT(std::abs(is), 0.02 * load.dot(before));
    EXPECT_NEAR(change->of_answer(within), is, 1e-7 * std::abs(is));
    const Eigen::MatrixXd moved = change->of_displacements(within).cast<double>();
    EXPECT_LT((moved.col(0) - (after - before)).norm(), 1e-4 * (after - before).norm());
  }
}

TEST(InclusionChange, IsNoneWhereNothingChanges) {
  BoxMeshSettings settings;
  settings.shells = 1;
  settings.cells = settings.cells_down = 1;
  const auto mesh = box_mesh(settings);
  ASSERT_TRUE(mesh);
  FreeMotion motion(*mesh);
  for (const int node : nodes_on_plane(*mesh, 2, -settings.size.z())) motion.hold(node);
  motion.number();
  const auto bare = linear_stiffness(*mesh, {}, motion);
  const auto factor = factorised(bare);
  ASSERT_TRUE(factor);
  const auto change = InclusionChange::prepare(bare, bare, *factor, {0, 1, 2});
  ASSERT_TRUE(change);
  EXPECT_EQ(change->count(), 0);
  EXPECT_EQ(change->of_answer(change->within(Eigen::VectorXd::Ones(3))), 0.0);
}

}  // namespace
}  // namespace palpate::physics::deformable
