#include "palpate/physics/deformable/site_law.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "palpate/physics/deformable/box_mesh.h"
#include "palpate/physics/deformable/half_space.h"
#include "palpate/physics/deformable/linear_body.h"
#include "palpate/physics/deformable/quick_indentation.h"
#include "palpate/physics/deformable/surface_load.h"

namespace palpate::physics::deformable {
namespace {

TEST(SurfaceLoad, IsAUnitForceWhereverItLies) {
  BoxMeshSettings settings;
  settings.size = {0.06, 0.06, 0.03};
  settings.cells = settings.cells_down = 3;
  settings.shells = 3;
  const auto mesh = *box_mesh(settings);
  for (const Vector3& place : {Vector3(0, 0, 0), Vector3(0.0031, -0.0012, 0.0), Vector3(0.012, 0.007, 0.0)})
    for (const double radius : {0.002, 0.005}) {
      const auto load = hertz_load(mesh, {place, {0, 0, 1}}, radius);
      Vector3 force = Vector3::Zero(), moment = Vector3::Zero();
      for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
        const Vector3 f = load.segment<3>(static_cast<Eigen::Index>(3 * i));
        force += f;
        moment += (mesh.nodes[i] - place).cross(f);
      }
      EXPECT_NEAR(force.z(), -1.0, 2e-3);
      EXPECT_LT(force.head<2>().norm(), 1e-12);
      EXPECT_LT(moment.norm(), 3e-3 * radius);
    }
  // The bottom is not what is pressed, and a disc that hangs over an edge loses what hangs over.
  EXPECT_NEAR(hertz_load(mesh, {{0.03, 0.0, 0.0}, {0, 0, 1}}, 0.004).sum(), -0.5, 2e-3);
}

TetMesh thin_plate() {
  BoxMeshSettings settings;
  settings.size = {0.06, 0.06, 0.002};
  settings.core_depth = 0.001;
  settings.cells = 3;
  settings.cells_down = 1;
  settings.shells = 3;
  return *box_mesh(settings);
}

TEST(SurfaceLoad, NeitherAPlatesBackNorAnotherPlateBeneathIsPressed) {
  const TetMesh plate = thin_plate();
  EXPECT_NEAR(hertz_load(plate, {}, 0.004).sum(), -1.0, 2e-3);
  TetMesh two = plate;
  const int count = static_cast<int>(plate.nodes.size());
  for (const auto& node : plate.nodes) two.nodes.push_back(node - Vector3(0.0, 0.0, 0.005));
  for (auto facet : plate.facets) {
    for (int& node : facet) node += count;
    two.facets.push_back(facet);
  }
  EXPECT_NEAR(hertz_load(two, {}, 0.004).sum(), -1.0, 2e-3);
}

TEST(SurfaceLoad, ManyLoadsAreAnsweredAsEachAlone) {
  const TetMesh plate = thin_plate();
  FreeMotion motion(plate);
  for (const int node : nodes_on_plane(plate, 2, -0.002)) motion.hold(node);
  motion.number();
  const auto factor = factorised(linear_stiffness(plate, {}, motion));
  ASSERT_TRUE(factor);
  std::vector<Eigen::VectorXd> loads;
  for (int k = 0; k < 40; ++k) loads.push_back(hertz_load(plate, {{4e-4 * k, 0.0, 0.0}, {0, 0, 1}}, 0.004));
  const auto all = answers(*factor, motion, loads);
  ASSERT_TRUE(all);
  ASSERT_EQ(all->size(), loads.size());
  for (const std::size_t k : {std::size_t{0}, std::size_t{31}, std::size_t{32}, std::size_t{39}}) {
    const auto one = answers(*factor, motion, {loads[k]});
    ASSERT_TRUE(one);
    EXPECT_NEAR((*all)[k] / one->front(), 1.0, 1e-9) << k;
  }
  EXPECT_GT(std::abs((*all)[0] / (*all)[32] - 1.0), 1e-6) << "places that answer differently";
}

TEST(SurfaceLoad, ADeepBlockAnswersAsAHalfSpaceAndALayer) {
  Indentation it;
  it.depths = {0.001};
  it.size = {0.2, 0.2, 0.06};
  it.fineness = 4.0;
  const auto law = site_law_of_block(it);
  ASSERT_TRUE(law) << law.error().message;
  // Dimitriadis' first term says what a wide bonded layer's compliance lacks: F = F_Hertz (1 - 2 alpha chi / pi).
  const double nu = it.material.matrix.poisson;
  const double alpha = -(1.2876 - 1.4678 * nu + 1.3442 * nu * nu) / (1.0 - nu);
  const double lacking = alpha / (3.14159265 * it.material.matrix.plane_strain() * it.size.z());
  EXPECT_NEAR(law->homogeneous / lacking, 1.0, 0.15);
}

TEST(SiteLaw, WithoutComplianceItIsHertzSoftened) {
  SiteLaw law;
  law.matter = {6000.0, 0.45};
  for (const double depth : {0.0005, 0.004, 0.008}) {
    const double softened = 1.0 - 0.124 * depth / law.radius;
    EXPECT_NEAR(law.force(depth) / (softened * hertz_force(law.matter, law.radius, depth)), 1.0, 1e-9);
    const double step = 1e-7;
    EXPECT_NEAR((law.energy(depth + step) - law.energy(depth - step)) / (2.0 * step) / law.force(depth), 1.0,
                1e-4);
  }
  EXPECT_EQ(law.force(-0.001), 0.0);
  EXPECT_EQ(law.energy(0.0), 0.0);
}

// Hertz's answer for a tip on a ball of radius 1/H, and for one in a hollow.
TEST(SiteLaw, ACurvedPlaceIsTouchedAsByAnotherTip) {
  SiteLaw law;
  law.matter = {6000.0, 0.45};
  for (const double curvature : {1.0 / 0.03, -1.0 / 0.05}) {
    law.curvature = curvature;
    const double as_wide = 1.0 / (1.0 / law.radius + curvature);
    for (const double depth : {0.0005, 0.004}) {
      const double softened = 1.0 - 0.124 * depth / law.radius;
      EXPECT_NEAR(law.force(depth) / (softened * hertz_force(law.matter, as_wide, depth)), 1.0, 1e-9);
      EXPECT_NEAR(law.contact_radius(depth) /
                      (hertz_contact_radius(as_wide, depth) * (1.0 - 0.1 * depth / law.radius)),
                  1.0, 1e-9);
    }
  }
}

// A spring of constant compliance c in series: the half-space yields d - F c.
TEST(SiteLaw, AConstantComplianceIsASpringInSeries) {
  SiteLaw law;
  law.matter = {6000.0, 0.45};
  law.homogeneous = -0.002;
  SiteLaw bare = law;
  bare.homogeneous = 0.0;
  for (const double depth : {0.001, 0.005}) {
    const double force = law.force(depth);
    EXPECT_NEAR(bare.force(depth - force * law.homogeneous) / force, 1.0, 1e-9);
  }
}

// With a compliance that depends on the contact's radius force and depth are derivatives of the complementary energy
// W0* + F^2 c(a(F)) / 2; so the stored energies of both parts sum to the work done.
TEST(SiteLaw, WorkIsStoredInTheHalfSpaceAndInTheRest) {
  SiteLaw law;
  law.matter = {6000.0, 0.45};
  law.footprints = {0.001, 0.012};
  law.inclusions = {-0.0005, -0.0035};
  SiteLaw bare = law;
  bare.footprints.clear();
  const double depth = 0.005, force = law.force(depth);
  // The half-space's own depth and footprint at that force, by bisection on the bare law.
  double low = 0.0, high = 0.012;
  for (int i = 0; i < 60; ++i) (bare.force(0.5 * (low + high)) < force ? low : high) = 0.5 * (low + high);
  const double c = -0.0005 - 0.003 * (footprint(law.radius, low) - 0.001) / 0.011;
  const double complementary = force * low - bare.energy(low) + 0.5 * force * force * c;
  EXPECT_NEAR((force * depth - law.energy(depth)) / complementary, 1.0, 1e-3);
}

TEST(SiteLaw, BeyondTheFootprintsThatAreKnownAnInclusionWeighsAsAtTheNearestOne) {
  SiteLaw law;
  law.matter = {6000.0, 0.45};
  law.footprints = {0.002, 0.003};
  law.inclusions = {-0.002, -0.004};
  for (const double depth : {0.0002, 0.005}) {
    SiteLaw constant;
    constant.matter = law.matter;
    constant.homogeneous = depth < 0.001 ? -0.002 : -0.004;
    ASSERT_EQ(law.contact_radius(depth) < 0.002, depth < 0.001);
    ASSERT_EQ(law.contact_radius(depth) > 0.003, depth > 0.001);
    EXPECT_NEAR(law.force(depth) / constant.force(depth), 1.0, 1e-9) << depth;
  }
}

TEST(SiteLaw, WhatAnInclusionAddsGrowsWithDepthAsFarAsItHasBeenTried) {
  SiteLaw law;
  law.matter = {6000.0, 0.45};
  law.footprints = {0.001, 0.012};
  law.inclusions = {-0.0005, -0.0035};
  law.layer = 0.003;
  const double rate = 0.187 / law.layer + 0.26 / law.radius;
  for (const double depth : {0.001, 0.003, 0.006}) {
    SiteLaw grown = law;
    grown.layer = std::numeric_limits<double>::infinity();
    for (double& inclusion : grown.inclusions) inclusion *= 1.0 + rate * std::min(depth, 1.6 * law.layer);
    EXPECT_NEAR(law.force(depth) / grown.force(depth), 1.0, 1e-9) << depth;
  }
}

// The table of docs/theory/deformable.md, and halfway between two of its entries.
TEST(SiteLaw, TheSofteningIsTheTabulatedOne) {
  EXPECT_NEAR(finite_strain_softening(0.40), 0.076, 1e-12);
  EXPECT_NEAR(finite_strain_softening(0.45), 0.124, 1e-12);
  EXPECT_NEAR(finite_strain_softening(0.465), 0.140, 1e-12);
  EXPECT_NEAR(finite_strain_softening(0.48), 0.156, 1e-12);
  EXPECT_NEAR(finite_strain_softening(0.49), 0.168, 1e-12);
}

TEST(SiteLaw, SetsOfInclusionsAreEachAsIfAlone) {
  Indentation it;
  it.fineness = 1.0;
  it.depths = {0.001};
  const Inclusion near{{0.0, 0.0, -0.010}, {0.004, 0.004, 0.004}, 10.0};
  const Inclusion deep{{0.0, 0.0, -0.020}, {0.004, 0.005, 0.006}, 10.0};
  const std::vector<std::vector<Inclusion>> sets{{near, deep}, {}, {deep}};
  std::vector<std::size_t> heard;
  const auto laws = site_laws_of_block(it, sets, [&](std::size_t done) { heard.push_back(done); });
  ASSERT_TRUE(laws) << laws.error().message;
  ASSERT_EQ(laws->size(), 3u);
  EXPECT_EQ(heard, (std::vector<std::size_t>{1, 2, 3}));
  EXPECT_NEAR((*laws)[0].layer, 0.006, 1e-9) << "of the nearest";
  EXPECT_NEAR((*laws)[2].layer, 0.014, 1e-9);
  EXPECT_TRUE((*laws)[1].inclusions.empty());
  it.material.inclusions = {deep};  // which counts for site_law_of_block alone
  const auto alone = site_law_of_block(it);
  ASSERT_TRUE(alone);
  EXPECT_EQ(alone->homogeneous, (*laws)[1].homogeneous);
  EXPECT_EQ(alone->inclusions, (*laws)[2].inclusions);
  const Inclusion out{{0.0, 0.0, -0.001}, {0.004, 0.004, 0.004}, 10.0};
  EXPECT_FALSE(site_laws_of_block(it, std::vector<std::vector<Inclusion>>{{deep}, {out}}));
}

// Neo-Hookean solutions of another program (axisymmetric elements), docs/theory/deformable.md.
TEST(SiteLaw, MeetsTheTablesOfAnotherSolver) {
  Indentation it;
  it.material.matrix = {6000.0, 0.45};
  it.size = {0.10635, 0.10635, 0.05};
  it.fineness = 4.0;
  it.depths = {0.002, 0.005};
  it.material.inclusions = {{{0.0, 0.0, -0.0125}, {0.0075, 0.0075, 0.0075}, 10.0}};
  const auto above = quick_indentation(it);
  ASSERT_TRUE(above) << above.error().message;
  EXPECT_NEAR((*above)[0].force / 0.1145, 1.0, 0.05);
  EXPECT_NEAR((*above)[1].force / 0.4623, 1.0, 0.05);
  it.material.inclusions.clear();
  const auto bare = quick_indentation(it);
  ASSERT_TRUE(bare) << bare.error().message;
  EXPECT_NEAR((*bare)[0].force / 0.08366, 1.0, 0.03);
  EXPECT_NEAR((*bare)[1].force / 0.3273, 1.0, 0.03);
  it.model = Model::linear;
  EXPECT_FALSE(quick_indentation(it));
}

}  // namespace
}  // namespace palpate::physics::deformable
