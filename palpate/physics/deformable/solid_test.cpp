#include "palpate/physics/deformable/solid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/random.h"
#include "palpate/physics/deformable/box_mesh.h"
#include "palpate/physics/deformable/tip_contact.h"

namespace palpate::physics::deformable {
namespace {

TetMesh small_block() {
  BoxMeshSettings settings;
  settings.size = {0.03, 0.03, 0.02};
  settings.core = 0.006;
  settings.core_depth = 0.006;
  settings.cells = settings.cells_down = 1;
  settings.shells = 2;
  return *box_mesh(settings);
}

Eigen::VectorXd random_displacements(const TetMesh& mesh, double size) {
  Random random(1, "solid/displacements");
  Eigen::VectorXd u(static_cast<Eigen::Index>(3 * mesh.nodes.size()));
  for (auto& value : u) value = random.uniform(-size, size);
  return u;
}

// A linear field of displacements on the boundary: the nodes within must take it, too, and exactly.
void expect_patch(Model model, const Matrix3& stretch) {
  auto mesh = small_block();
  FreeMotion motion(mesh);
  Eigen::VectorXd wanted(static_cast<Eigen::Index>(3 * mesh.nodes.size()));
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    wanted.segment<3>(static_cast<Eigen::Index>(3 * i)) = stretch * mesh.nodes[i];
  for (const auto& facet : mesh.facets)
    for (const int node : facet) motion.hold(node);
  motion.number();
  ASSERT_GT(motion.count(), 100);
  const Solid solid(mesh, {}, model);
  auto matrix = stiffness_pattern(mesh, motion);
  auto factor = SparseFactor::analyse(matrix);
  ASSERT_TRUE(factor);
  Eigen::VectorXd u = wanted;
  motion.add(motion.free_part(wanted), -0.3, u);
  for (int step = 0; step < 8; ++step) {
    Eigen::VectorXd way = -motion.free_part(solid.forces(u));
    std::fill(matrix.values.begin(), matrix.values.end(), 0.0);
    solid.add_stiffness(u, motion, matrix);
    ASSERT_TRUE(factor->factorise(matrix));
    ASSERT_TRUE(factor->solve(way));
    motion.add(way, 1.0, u);
  }
  EXPECT_LT((u - wanted).norm(), 1e-9 * wanted.norm());
}

TEST(Solid, ALinearFieldIsReproducedExactly) {
  Matrix3 stretch;
  stretch << 0.05, 0.02, -0.03, 0.01, -0.04, 0.02, 0.0, 0.03, 0.02;
  expect_patch(Model::linear, stretch);
  expect_patch(Model::neo_hookean, stretch);
}

TEST(Solid, ForcesAndStiffnessAreDerivativesOfTheEnergy) {
  auto mesh = small_block();
  mesh.nodes[20] += Vector3(2e-4, -3e-4, 1e-4);  // bends edges: the elements there are curved
  FreeMotion motion(mesh);
  motion.number();
  Material material;
  material.inclusions.push_back({{0.002, 0.0, -0.006}, {0.004, 0.004, 0.004}, 10.0});
  for (const Model model : {Model::linear, Model::neo_hookean}) {
    const Solid solid(mesh, material, model);
    const Eigen::VectorXd u = random_displacements(mesh, 2e-4),
                          way = random_displacements(mesh, 1e-3).reverse();
    const double step = 1e-5;
    const double slope = (solid.energy(u + step * way) - solid.energy(u - step * way)) / (2.0 * step);
    EXPECT_NEAR(slope / solid.forces(u).dot(way), 1.0, 1e-6);
    auto matrix = stiffness_pattern(mesh, motion);
    solid.add_stiffness(u, motion, matrix);
    const Eigen::VectorXd change =
        (solid.forces(u + step * way) - solid.forces(u - step * way)) / (2.0 * step);
    EXPECT_LT((matrix.times(way) - change).norm(), 1e-5 * change.norm());
  }
}

// The half-space z > 1/2 is half of the part of a unit tetrahedron that lies nearest to its upper corner, as seen by
// barycentric coordinates, and nothing of the other three parts; whichever corner is named first.
TEST(Solid, WhereAnInclusionsSurfaceCutsAnElementCompliancesAreAveraged) {
  constexpr double kFar = 1e4;  // a ball so large that its surface is flat here
  Material material;
  material.inclusions = {{{0.0, 0.0, 0.5 + kFar}, {kFar, kFar, kFar}, 10.0}};
  const double shear = material.matrix.shear(), expected = 1.0 / (0.5 / 10.0 + 0.5);
  for (const auto& order :
       {std::array{0, 1, 2, 3}, {3, 0, 2, 1}, {1, 2, 0, 3}}) {  // each turns the same way round
    const auto mesh = *quadratic_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {order});
    const Solid solid(mesh, material, Model::linear);
    const auto& points = solid.points().front();
    for (std::size_t q = 0; q < 4; ++q) {
      const double ratio = order[q] == 3 ? expected : 1.0;
      EXPECT_NEAR(points[q].shear / shear / ratio, 1.0, 0.04) << q;
      EXPECT_NEAR(points[q].bulk / points[q].shear, material.matrix.bulk() / shear, 1e-9);
    }
  }
}

TEST(Solid, RigidMotionStoresNothing) {
  const auto mesh = small_block();
  const Matrix3 R = so3_exp(Vector3(0.3, 0.2, -1.0)).toRotationMatrix();
  Eigen::VectorXd u(static_cast<Eigen::Index>(3 * mesh.nodes.size()));
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    u.segment<3>(static_cast<Eigen::Index>(3 * i)) =
        R * mesh.nodes[i] + Vector3(0.1, 0.2, 0.3) - mesh.nodes[i];
  const Solid solid(mesh, {}, Model::neo_hookean);
  EXPECT_LT(solid.energy(u), 1e-14);
  EXPECT_LT(solid.forces(u).norm(), 1e-10);
  // Small-strain matter knows small turns alone: this turn it takes for a strain.
  EXPECT_GT(Solid(mesh, {}, Model::linear).energy(u), 1e-3);
}

TEST(TipContact, PenetrationHasTheNormalAndCurvatureOfItsTip) {
  const RigidTip tip{{0.001, 0.0, 0.005}, {0.0, 0.0, 1.0}, 0.006};
  Random random(2, "tip_contact/places");
  for (int i = 0; i < 100; ++i) {
    const Vector3 place(random.uniform(-0.006, 0.006), random.uniform(-0.006, 0.006),
                        random.uniform(0.0, 0.012));
    if (std::abs(place.z() - tip.centre.z()) < 1e-4 || (place - tip.centre).norm() < 1e-3) continue;
    const auto here = penetration(tip, place);
    for (int d = 0; d < 3; ++d) {
      Vector3 step = Vector3::Zero();
      step[d] = 1e-7;
      if ((place - tip.centre).head<2>().norm() < 5e-4) continue;
      const auto up = penetration(tip, place + step), down = penetration(tip, place - step);
      EXPECT_NEAR((up.depth - down.depth) / 2e-7, -here.normal[d], 1e-5);
      EXPECT_LT(((down.normal - up.normal) / 2e-7 - here.curvature.col(d)).norm(),
                1e-3 * here.curvature.norm());
    }
  }
  EXPECT_NEAR(penetration(tip, {0.001, 0.0, -0.0005}).depth, 0.0005, 1e-12);
  EXPECT_NEAR(penetration(tip, {0.006, 0.0, 0.02}).depth, 0.001, 1e-12) << "beside the shaft";
  const auto middle = penetration(tip, tip.centre);
  EXPECT_EQ(middle.depth, tip.radius);
  EXPECT_TRUE(middle.normal.allFinite() && middle.curvature.allFinite());
}

// With h the height of the tip's centre the energy is  pi k integral from h to R of (R - s)^2 s ds.
TEST(TipContact, ASmallTipInTheMiddleOfAFacetIsFelt) {
  const auto mesh = small_block();
  const auto top = facets_on_plane(mesh, 2, 0.0);
  const TipContact contact(mesh, top, 1e7, 16);
  const Eigen::VectorXd u = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * mesh.nodes.size()));
  // None of the facet's six nodes lies within the tip.
  const auto X = places_of(mesh, mesh.facets[static_cast<std::size_t>(top.front())]);
  const Vector3 middle = X.topRows<3>().colwise().mean().transpose();
  const double R = 0.001, h = 0.0005;
  ASSERT_GT((X.rowwise() - middle.transpose()).rowwise().norm().minCoeff(), R);
  const RigidTip tip{middle + Vector3(0.0, 0.0, h), {0.0, 0.0, 1.0}, R};
  const double energy = std::numbers::pi * 1e7 * std::pow(R, 4) * 5.0 / 192.0;
  EXPECT_NEAR(contact.energy(tip, u) / energy, 1.0, 0.05);
  EXPECT_NEAR(contact.state(tip, u).radius, std::sqrt(R * R - h * h), 2e-4);
}

TEST(TipContact, AShareOfItsStiffnessIsThatShare) {
  const auto mesh = small_block();
  const TipContact contact(mesh, facets_on_plane(mesh, 2, 0.0), 1e7, 3);
  FreeMotion motion(mesh);
  motion.number();
  const RigidTip tip{{0.0005, 0.0, 0.005}, {0.0, 0.0, 1.0}, 0.006};
  const Eigen::VectorXd u = random_displacements(mesh, 1e-4);
  auto whole = stiffness_pattern(mesh, motion), share = whole;
  contact.add_stiffness(tip, u, motion, true, whole);
  contact.add_stiffness(tip, u, motion, true, share, 0.25);
  double largest = 0.0, off = 0.0;
  for (std::size_t k = 0; k < whole.values.size(); ++k) {
    largest = std::max(largest, std::abs(whole.values[k]));
    off = std::max(off, std::abs(share.values[k] - 0.25 * whole.values[k]));
  }
  EXPECT_GT(largest, 0.0);
  EXPECT_LT(off, 1e-12 * largest);
}

TEST(TipContact, ForcesAndStiffnessAreDerivativesOfTheEnergy) {
  const auto mesh = small_block();
  const TipContact contact(mesh, facets_on_plane(mesh, 2, 0.0), 1e7, 3);
  FreeMotion motion(mesh);
  motion.number();
  const RigidTip tip{{0.0005, 0.0, 0.005}, {0.0, 0.0, 1.0}, 0.006};
  const Eigen::VectorXd u = random_displacements(mesh, 1e-4),
                        way = random_displacements(mesh, 1e-3).reverse();
  const double step = 1e-6;
  Eigen::VectorXd forces = Eigen::VectorXd::Zero(u.size()), above = forces, below = forces;
  contact.add_forces(tip, u, forces);
  contact.add_forces(tip, u + step * way, above);
  contact.add_forces(tip, u - step * way, below);
  const double slope =
      (contact.energy(tip, u + step * way) - contact.energy(tip, u - step * way)) / (2.0 * step);
  EXPECT_NEAR(slope / forces.dot(way), 1.0, 1e-5);
  auto matrix = stiffness_pattern(mesh, motion);
  contact.add_stiffness(tip, u, motion, true, matrix);
  const Eigen::VectorXd change = (above - below) / (2.0 * step);
  EXPECT_LT((matrix.times(way) - change).norm(), 1e-3 * change.norm());
  // What the tip gets is what the surface gives.
  Vector3 sum = Vector3::Zero();
  for (Eigen::Index i = 0; i < forces.size(); i += 3) sum += forces.segment<3>(i);
  EXPECT_LT((contact.state(tip, u).force - sum).norm(), 1e-12 * sum.norm() + 1e-15);
  EXPECT_GT(contact.state(tip, u).force.z(), 0.0);
}

}  // namespace
}  // namespace palpate::physics::deformable
