#include "palpate/physics/deformable/indentation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "palpate/physics/deformable/half_space.h"

namespace palpate::physics::deformable {
namespace {

// Axisymmetric finite-strain elements of another program (nine-node quadrilaterals), a cylinder of 60 mm radius and
// 50 mm height, R 5 mm, E 6 kPa, nu 0.45; a square block of the same area is stiffer by up to 0.5 %.
struct Tabulated {
  Model model;
  std::vector<double> depths, forces, radii;
};
const Tabulated kTables[] = {{Model::linear, {0.001, 0.003}, {0.02246, 0.1028}, {2.2e-3, 3.4e-3}},
                             {Model::neo_hookean, {0.002}, {0.0637}, {3.1e-3}}};

Indentation tabulated_block() {
  Indentation it;
  it.material.matrix = {6000.0, 0.45};
  const double side = 0.06 * std::sqrt(std::numbers::pi);
  it.size = {side, side, 0.05};
  it.radius = 0.005;
  it.depths = {0.001};
  it.fineness = 3.0;
  return it;
}

TEST(Indentation, TheTablesOfAnotherSolverAreMet) {
  for (const auto& table : kTables) {
    auto it = tabulated_block();
    it.model = table.model;
    it.depths = table.depths;
    const auto points = solve_indentation(it);
    ASSERT_TRUE(points) << points.error().message;
    const double spacing = hertz_contact_radius(it.radius, table.depths.back()) / it.fineness / 2.0;
    for (std::size_t k = 0; k < points->size(); ++k) {
      EXPECT_NEAR((*points)[k].force / table.forces[k], 1.0, 0.03) << k;
      EXPECT_NEAR((*points)[k].contact_radius, table.radii[k], spacing) << k;
    }
  }
}

// Small depths on a thin layer and nearly incompressible matter: what locks is far too stiff there.
TEST(Indentation, ShallowPressesAreHertzTimesTheLayersFactor) {
  for (const double poisson : {0.45, 0.49}) {
    auto it = tabulated_block();
    it.model = Model::linear;
    it.material.matrix.poisson = poisson;
    it.size.z() = 0.02;
    it.depths = {0.05 * it.radius};
    it.fineness = 4.0;
    const auto points = solve_indentation(it);
    ASSERT_TRUE(points) << points.error().message;
    const double expected = hertz_force(it.material.matrix, it.radius, it.depths[0]) *
                            bonded_layer_factor(poisson, it.radius, it.depths[0], it.size.z());
    EXPECT_NEAR((*points)[0].force / expected, 1.0, 0.03) << poisson;
  }
}

TEST(Indentation, AnInclusionBesideTheMiddleWeighsAsItsMirrorImageDoes) {
  auto it = tabulated_block();
  it.model = Model::linear;
  it.fineness = 2.0;
  it.depths = {0.002};
  const auto force = [&](const Vector3& centre) {
    it.material.inclusions = {{centre, {0.005, 0.005, 0.005}, 10.0}};
    const auto points = solve_indentation(it);
    return points ? points->front().force : std::numeric_limits<double>::quiet_NaN();
  };
  const double beside = force({0.006, 0.0, -0.008}), mirrored = force({0.0, -0.006, -0.008});
  EXPECT_NEAR(mirrored / beside, 1.0, 0.01) << "one half of the block is meshed, and the other half";
  const double above = force({0.0, 0.0, -0.008});
  it.material.inclusions.clear();
  const double without = solve_indentation(it)->front().force;
  EXPECT_GT(above, 1.05 * beside);
  EXPECT_GT(beside, 1.02 * without);
}

TEST(Indentation, DepthsComeBackInTheirOrderAndProgressEndsAtOne) {
  auto it = tabulated_block();
  it.model = Model::linear;
  it.fineness = 1.0;
  it.depths = {0.002, 0.0002, 0.001};  // of two meshes
  std::vector<double> heard;
  const auto points = solve_indentation(it, [&](double share) { heard.push_back(share); });
  ASSERT_TRUE(points) << points.error().message;
  ASSERT_EQ(points->size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ((*points)[k].depth, it.depths[k]);
    EXPECT_NEAR((*points)[k].force / hertz_force(it.material.matrix, it.radius, it.depths[k]), 1.0, 0.2) << k;
  }
  ASSERT_EQ(heard.size(), 3u);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(heard[k], (k + 1.0) / 3.0, 1e-12);
}

TEST(Indentation, WhatMakesNoSenseIsRefused) {
  const auto refuses = [](auto change) {
    auto it = tabulated_block();
    change(it);
    const auto points = solve_indentation(it);
    return !points && points.error().kind == Error::Kind::wrong_use;
  };
  EXPECT_TRUE(refuses([](Indentation& it) { it.depths.clear(); }));
  EXPECT_TRUE(refuses([](Indentation& it) { it.depths = {0.0}; }));
  EXPECT_TRUE(refuses([](Indentation& it) { it.depths = {0.01}; }));
  EXPECT_TRUE(refuses([](Indentation& it) { it.radius = -1.0; }));
  EXPECT_TRUE(refuses([](Indentation& it) { it.fineness = 0.5; }));
  EXPECT_TRUE(refuses([](Indentation& it) { it.fineness = std::nan(""); }));
  EXPECT_TRUE(refuses([](Indentation& it) { it.size.x() = 0.01; }));
  EXPECT_TRUE(refuses([](Indentation& it) { it.size.z() = std::nan(""); }));
  EXPECT_TRUE(refuses([](Indentation& it) { it.material.matrix.poisson = 0.5; }));
  EXPECT_TRUE(refuses([](Indentation& it) {
    it.material.inclusions = {{{0, 0, 0}, {0.01, 0.01, 0.01}, 2.0}};
  }));
}

}  // namespace
}  // namespace palpate::physics::deformable
