#include "palpate/physics/deformable/tet_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <string>

#include "palpate/physics/deformable/box_mesh.h"
#include "palpate/physics/deformable/quadratic_shape.h"

namespace palpate::physics::deformable {
namespace {

TetMesh one_tetrahedron() {
  return *quadratic_mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}});
}

TEST(TetMesh, OneTetrahedronIsAsEuclidSays) {
  const auto mesh = one_tetrahedron();
  EXPECT_EQ(mesh.nodes.size(), 10U);
  EXPECT_EQ(mesh.facets.size(), 4U);
  EXPECT_NEAR(volume(mesh), 1.0 / 6.0, 1e-15);
  EXPECT_NEAR(surface_area(mesh), 1.5 + 0.5 * std::sqrt(3.0), 1e-14);
  const auto angles = dihedral_angles(mesh);
  EXPECT_NEAR(angles.largest, 0.5 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(angles.smallest, std::acos(1.0 / std::sqrt(3.0)), 1e-12);
}

// Gauss: the flux of x through a closed surface that is oriented outwards is three times the volume.
double flux_of_place(const TetMesh& mesh) {
  double flux = 0.0;
  for (const auto& facet : mesh.facets) {
    const auto X = places_of(mesh, facet);
    for (const auto& point : facet_rule()) {
      const Eigen::Matrix<double, 3, 2> t = X.transpose() * facet_shape_derivatives(point.L);
      const Vector3 place = X.transpose() * facet_shape(point.L);
      flux += 0.5 * point.weight * place.dot(Vector3(t.col(0)).cross(Vector3(t.col(1))));
    }
  }
  return flux;
}

TEST(TetMesh, TheSurfaceIsClosedAndFacesOutwards) {
  auto mesh = *box_mesh({});
  EXPECT_NEAR(flux_of_place(mesh) / (3.0 * volume(mesh)), 1.0, 1e-12);
  for (std::size_t f = 0; f < mesh.facets.size(); ++f) {
    const auto& element = mesh.elements.at(static_cast<std::size_t>(mesh.facet_elements.at(f)));
    for (const int node : mesh.facets[f])
      ASSERT_NE(std::find(element.begin(), element.end(), node), element.end()) << "facet " << f;
  }
  // With bent edges the elements are curved; the identity holds still.
  for (auto& node : mesh.nodes) node += Vector3(0.3 * node.y() * node.y(), 0.0, 0.5 * node.x() * node.y());
  EXPECT_NEAR(flux_of_place(mesh) / (3.0 * volume(mesh)), 1.0, 1e-9);
}

TEST(TetMesh, ShapeFunctionsAreOneAtTheirNodeAndSlopesAreTheirs) {
  const Barycentric4 L{0.1, 0.2, 0.3, 0.4};
  EXPECT_NEAR(element_shape(L).sum(), 1.0, 1e-15);
  const auto dN = element_shape_derivatives(L);
  for (int d = 0; d < 3; ++d) {
    Barycentric4 up = L, down = L;
    const double step = 1e-6;
    up[static_cast<std::size_t>(d) + 1] += step, up[0] -= step;
    down[static_cast<std::size_t>(d) + 1] -= step, down[0] += step;
    const Eigen::VectorXd slope = (element_shape(up) - element_shape(down)) / (2.0 * step);
    EXPECT_LT((slope - dN.col(d)).norm(), 1e-9);
  }
  const Barycentric3 M{0.2, 0.5, 0.3};
  const auto dM = facet_shape_derivatives(M);
  for (int d = 0; d < 2; ++d) {
    Barycentric3 up = M, down = M;
    const double step = 1e-6;
    up[static_cast<std::size_t>(d) + 1] += step, up[0] -= step;
    down[static_cast<std::size_t>(d) + 1] -= step, down[0] += step;
    EXPECT_LT(((facet_shape(up) - facet_shape(down)) / (2.0 * step) - dM.col(d)).norm(), 1e-9);
  }
}

// a! b! c! d! 3! / (a + b + c + d + 3)!: the mean of a product of barycentric coordinates over a tetrahedron.
TEST(TetMesh, TheRulesIntegrateTheirDegree) {
  const auto mean4 = [](int a, int b) {
    double sum = 0.0;
    for (const auto& point : element_rule())
      sum += point.weight * std::pow(point.L[0], a) * std::pow(point.L[2], b);
    return sum;
  };
  EXPECT_NEAR(mean4(1, 0), 0.25, 1e-15);
  EXPECT_NEAR(mean4(1, 1), 1.0 / 20.0, 1e-15);
  EXPECT_NEAR(mean4(2, 0), 0.1, 1e-15);
  const auto mean3 = [](int a, int b) {
    double sum = 0.0;
    for (const auto& point : facet_rule())
      sum += point.weight * std::pow(point.L[1], a) * std::pow(point.L[2], b);
    return sum;
  };
  EXPECT_NEAR(mean3(5, 0), 2.0 / 42.0, 1e-14);
  EXPECT_NEAR(mean3(2, 3), 2.0 * 2.0 * 6.0 / 5040.0, 1e-14);
}

TEST(TetMesh, WhatIsNoBodyIsRefused) {
  const std::vector<Vector3> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  EXPECT_FALSE(quadratic_mesh(corners, {{0, 2, 1, 3}})) << "inside out";
  EXPECT_FALSE(quadratic_mesh(corners, {{0, 1, 2, 7}})) << "no such corner";
  EXPECT_FALSE(quadratic_mesh(corners, {{0, 1, 2, 2}})) << "flat";
  EXPECT_FALSE(quadratic_mesh(corners, {{0, 1, 2, 3}, {0, 1, 2, 3}, {0, 1, 2, 4}}))
      << "three at one triangle";
  auto mesh = one_tetrahedron();
  EXPECT_TRUE(check(mesh));
  mesh.nodes[4] = {3.0, 3.0, 3.0};
  EXPECT_FALSE(check(mesh)) << "a middle far from its edge";
  mesh.nodes[4].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(check(mesh));
  mesh.nodes[4] = {0.2, 0.0, 0.0};
  EXPECT_FALSE(check(mesh)) << "turned inside out at a corner alone";
  for (const int odd : {-1, 10}) {
    mesh = one_tetrahedron();
    mesh.elements[0][5] = odd;
    const auto checked = check(mesh);
    ASSERT_FALSE(checked);
    EXPECT_NE(checked.error().message.find("has node"), std::string::npos) << checked.error().message;
  }
}

TEST(BoxMesh, HasTheBlocksVolumeFacesAndGrading) {
  for (const bool half : {false, true}) {
    BoxMeshSettings settings;
    settings.size = {0.12, 0.09, 0.05};
    settings.half_x = half;
    settings.half_y = half;
    const auto mesh = box_mesh(settings);
    ASSERT_TRUE(mesh) << mesh.error().message;
    EXPECT_TRUE(check(*mesh));
    const double part = half ? 0.25 : 1.0;
    EXPECT_NEAR(volume(*mesh), part * 0.12 * 0.09 * 0.05, 1e-12);
    EXPECT_NEAR(surface_area(*mesh),
                half ? 2 * (0.06 * 0.045 + 0.06 * 0.05 + 0.045 * 0.05)
                     : 2 * (0.12 * 0.09 + 0.12 * 0.05 + 0.09 * 0.05),
                1e-10);
    double top = 0.0, nearest = 1.0;
    TetMesh lid = *mesh;
    lid.facets.clear();
    for (const int f : facets_on_plane(*mesh, 2, 0.0))
      lid.facets.push_back(mesh->facets[static_cast<std::size_t>(f)]);
    top = surface_area(lid);
    EXPECT_NEAR(top, part * 0.12 * 0.09, 1e-10);
    for (const auto& node : mesh->nodes)
      if (node.norm() > 0.0) nearest = std::min(nearest, node.norm());
    EXPECT_NEAR(nearest, 0.0005, 1e-12) << "half of a core cell";
    EXPECT_GT(dihedral_angles(*mesh).smallest, 0.1);
    EXPECT_FALSE(nodes_on_plane(*mesh, 2, -0.05).empty());
  }
}

TEST(BoxMesh, ACoreThatDoesNotFitIsRefused) {
  BoxMeshSettings settings;
  settings.core = 0.06;
  EXPECT_FALSE(box_mesh(settings));
  settings = {};
  settings.shells = 0;
  EXPECT_FALSE(box_mesh(settings));
}

}  // namespace
}  // namespace palpate::physics::deformable
