#include "palpate/scene/mesh.h"

#include <gtest/gtest.h>

#include <map>
#include <numbers>
#include <utility>

namespace palpate::scene {
namespace {

// Volume by the divergence theorem: positive only if the triangles face outwards.
double volume(const TriangleMesh& mesh) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) {
    sum += mesh.vertices[t[0]].dot(mesh.vertices[t[1]].cross(mesh.vertices[t[2]])) / 6.0;
  }
  return sum;
}

// Closed and oriented: every directed edge occurs once, and so does its reverse.
void expect_closed(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  }
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(edges.contains({edge.second, edge.first})) << edge.first << "-" << edge.second;
  }
}

// Area of a regular polygon with n corners on a circle.
double polygon_area(double radius, int n) {
  return 0.5 * n * radius * radius * std::sin(2.0 * std::numbers::pi / n);
}

TEST(Mesh, RoundShapesAreClosedAndFaceOutwards) {
  const auto disc = disc_mesh(0.075, 0.012, 32);
  expect_closed(disc);
  EXPECT_NEAR(volume(disc), 0.012 * polygon_area(0.075, 32), 1e-15);
  for (const auto& v : disc.vertices) EXPECT_NEAR(std::abs(v.y()), 0.006, 1e-15);

  const Vector3 a(0.1, -0.2, 0.3), b(-0.2, 0.4, 0.5);
  const auto cylinder = cylinder_mesh(a, b, 0.02, 20);
  expect_closed(cylinder);
  EXPECT_NEAR(volume(cylinder), (b - a).norm() * polygon_area(0.02, 20), 1e-15);

  const auto sphere = sphere_mesh(0.02);
  expect_closed(sphere);
  for (const auto& v : sphere.vertices) EXPECT_NEAR(v.norm(), 0.02, 1e-15);
  const double ball = 4.0 / 3.0 * std::numbers::pi * std::pow(0.02, 3);
  EXPECT_LT(volume(sphere), ball);          // inscribed
  EXPECT_GT(volume(sphere), 0.985 * ball);  // 24 x 48 facets lose about 1 %
}

TEST(Mesh, BoxIsClosedAndFacesOutwards) {
  const auto box = box_mesh({-1, 2, 3}, {1, 5, 4});
  expect_closed(box);
  EXPECT_NEAR(volume(box), 2.0 * 3.0 * 1.0, 1e-12);
}

TEST(Mesh, RectangleFacesAlongXCrossY) {
  const Vector3 x(0.75, 0, 0), y(0, 0.1, -1.0);
  const auto mesh = rectangle_mesh({0.1, 0.2, 0.3}, x, y);
  ASSERT_EQ(mesh.triangles.size(), 2u);
  Vector3 area = Vector3::Zero();
  for (const auto& t : mesh.triangles) {
    const Vector3 n =
        0.5 * (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    EXPECT_GT(n.dot(x.cross(y)), 0.0);
    area += n;
  }
  EXPECT_NEAR((area - x.cross(y)).norm(), 0.0, 1e-15);
}

TEST(Mesh, AppendKeepsBothParts) {
  auto mesh = box_mesh({0, 0, 0}, {1, 1, 1});
  append(mesh, box_mesh({2, 0, 0}, {3, 2, 1}));
  EXPECT_NEAR(volume(mesh), 3.0, 1e-12);
  append(mesh, mesh);
  EXPECT_NEAR(volume(mesh), 6.0, 1e-12);
}

TEST(Mesh, ShapesThatCannotBeAreRefused) {
  EXPECT_THROW(disc_mesh(0.1, 0.01, 2), std::invalid_argument);
  EXPECT_THROW(cylinder_mesh({0, 0, 0}, {0, 0, 0}, 0.1), std::invalid_argument);
  EXPECT_THROW(sphere_mesh(0.1, 1, 8), std::invalid_argument);
}

TEST(MeshVersion, IsOneOfItsOwnForEachMeshAndEachOfItsStates) {
  TriangleMesh mesh = box_mesh({-1, -1, -1}, {1, 1, 1});
  const auto first = mesh.version.number();
  EXPECT_NE(first, 0u);
  const TriangleMesh copy = mesh;
  EXPECT_EQ(mesh.version.number(), first);
  EXPECT_NE(copy.version.number(), first);
  mesh.version.raise();
  EXPECT_GT(mesh.version.number(), first);
  const auto raised = mesh.version.number();
  TriangleMesh moved = std::move(mesh);
  EXPECT_EQ(moved.version.number(), raised);
  moved = copy;  // other vertices
  EXPECT_GT(moved.version.number(), raised);
  EXPECT_NE(moved.version.number(), copy.version.number());
  const auto before = moved.version.number();
  append(moved, copy);
  EXPECT_GT(moved.version.number(), before);
}

}  // namespace
}  // namespace palpate::scene
