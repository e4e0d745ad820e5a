// Bodies of known volume and area, filled with elements.
#include "palpate/physics/deformable/stuffed_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <set>
#include <vector>

#include "palpate/physics/deformable/refined_mesh.h"

namespace palpate::physics::deformable {
namespace {

constexpr double kBallRadius = 0.04;
const Vector3 kBallMiddle(0.0013, -0.0021, 0.0007);

double to_ball(const Vector3& p) { return (p - kBallMiddle).norm() - kBallRadius; }

// Not a distance, but its sign and its zero are right, and it is nearly linear there.
double to_ellipsoid(const Vector3& p) {
  const Vector3 r(0.05, 0.04, 0.03);
  const double k = p.cwiseQuotient(r).norm(), slope = p.cwiseQuotient(r.cwiseProduct(r)).norm();
  return slope > 0.0 ? k * (k - 1.0) / slope : -0.03;
}

Expected<TetMesh> ball_of_elements(double spacing) {
  const Vector3 half = Vector3::Constant(kBallRadius);
  return stuffed_mesh(to_ball, {kBallMiddle - half, kBallMiddle + half, spacing});
}

// Every edge of the surface belongs to two facets: it is closed and meets itself nowhere.
bool surface_is_closed(const TetMesh& mesh) {
  std::map<std::pair<int, int>, int> edges;
  for (const auto& facet : mesh.facets)
    for (std::size_t i = 0; i < 3; ++i)
      ++edges[{std::min(facet[i], facet[(i + 1) % 3]), std::max(facet[i], facet[(i + 1) % 3])}];
  return std::all_of(edges.begin(), edges.end(), [](const auto& edge) { return edge.second == 2; });
}

TEST(StuffedMesh, VolumeAndAreaOfABallAreMetWithTheSquareOfTheSpacing) {
  const double volume_of_ball = 4.0 / 3.0 * std::numbers::pi * std::pow(kBallRadius, 3);
  const double area_of_ball = 4.0 * std::numbers::pi * kBallRadius * kBallRadius;
  double before = 0.0;
  for (const double spacing : {0.010, 0.005}) {
    const auto mesh = ball_of_elements(spacing);
    ASSERT_TRUE(mesh) << mesh.error().message;
    EXPECT_TRUE(check(*mesh));
    EXPECT_TRUE(surface_is_closed(*mesh));
    const double off = 1.0 - volume(*mesh) / volume_of_ball;
    EXPECT_GT(off, 0.0);  // flat facets of corners on the ball
    EXPECT_LT(off, 0.3 * std::pow(spacing / kBallRadius, 2));
    EXPECT_NEAR(surface_area(*mesh) / area_of_ball, 1.0, 0.3 * std::pow(spacing / kBallRadius, 2));
    if (before > 0.0) {
      EXPECT_NEAR(before / off, 4.0, 1.0);
    }
    before = off;
  }
}

TEST(StuffedMesh, CornersOfTheSurfaceLieOnIt) {
  const auto mesh = ball_of_elements(0.01);
  ASSERT_TRUE(mesh);
  for (const auto& facet : mesh->facets)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(to_ball(mesh->nodes[static_cast<std::size_t>(facet[k])]), 0.0, 1e-7);
}

// The paper proves 10.7 to 164.8 degrees for any surface that is smooth beside the lattice.
TEST(StuffedMesh, NoElementIsFlat) {
  for (const double spacing : {0.013, 0.0101, 0.0083}) {
    const auto mesh = stuffed_mesh(to_ellipsoid, {{-0.05, -0.04, -0.03}, {0.05, 0.04, 0.03}, spacing});
    ASSERT_TRUE(mesh) << mesh.error().message;
    EXPECT_TRUE(check(*mesh));
    const auto angles = dihedral_angles(*mesh);
    EXPECT_GT(angles.smallest * 180.0 / std::numbers::pi, 18.0) << spacing;
    EXPECT_LT(angles.largest * 180.0 / std::numbers::pi, 142.0) << spacing;
    EXPECT_NEAR(volume(*mesh) / (4.0 / 3.0 * std::numbers::pi * 0.05 * 0.04 * 0.03), 1.0, 0.04);
  }
}

TEST(StuffedMesh, WhatItCannotFillIsSaid) {
  const auto plate = [](const Vector3& p) { return (p.cwiseAbs() - Vector3(0.05, 0.05, 0.001)).maxCoeff(); };
  const StuffedMeshSettings coarse{{-0.05, -0.05, -0.001}, {0.05, 0.05, 0.001}, 0.02};
  EXPECT_FALSE(stuffed_mesh(plate, coarse));
  const auto two_balls = [](const Vector3& p) {
    return std::min((p - Vector3(0.04, 0, 0)).norm(), (p + Vector3(0.04, 0, 0)).norm()) - 0.02;
  };
  const auto two = stuffed_mesh(two_balls, {{-0.06, -0.02, -0.02}, {0.06, 0.02, 0.02}, 0.008});
  ASSERT_FALSE(two);
  EXPECT_NE(two.error().message.find("parts"), std::string::npos);
  EXPECT_FALSE(stuffed_mesh(to_ball, {{-0.04, -0.04, -0.04}, {0.04, 0.04, 0.04}, 0.0}));
  EXPECT_FALSE(stuffed_mesh(to_ball, {{-0.04, -0.04, -0.04}, {0.04, 0.04, 0.04}, 1e-4}));
}

TEST(StuffedMesh, ACrumbBesideTheBodyIsLeftOut) {
  const auto with_crumb = [](const Vector3& p) {
    return std::min(to_ball(p), (p - kBallMiddle - Vector3(0.055, 0.0, 0.0)).norm() - 0.005);
  };
  const Vector3 half = Vector3::Constant(0.065);
  const StuffedMeshSettings settings{kBallMiddle - half, kBallMiddle + half, 0.006};
  const auto alone = stuffed_mesh(to_ball, settings), beside = stuffed_mesh(with_crumb, settings);
  ASSERT_TRUE(alone);
  ASSERT_TRUE(beside) << beside.error().message;
  EXPECT_EQ(beside->elements.size(), alone->elements.size());
  EXPECT_NEAR(volume(*beside) / volume(*alone), 1.0, 1e-12);
}

TEST(RefinedMesh, IsFineWhereItIsAskedForAndFollowsTheSurface) {
  const auto mesh = ball_of_elements(0.016);
  ASSERT_TRUE(mesh);
  const Vector3 top = kBallMiddle + Vector3(0.0, 0.0, kBallRadius);
  const auto wanted = [&](const Vector3& p) { return std::max(0.004, 0.6 * (p - top).norm()); };
  const auto onto = [](const Vector3& p) {
    return Vector3(kBallMiddle + kBallRadius * (p - kBallMiddle).normalized());
  };
  const auto fine = refined_mesh(*mesh, wanted, onto);
  ASSERT_TRUE(fine) << fine.error().message;
  EXPECT_TRUE(check(*fine));
  EXPECT_TRUE(surface_is_closed(*fine));
  EXPECT_GT(volume(*fine), volume(*mesh));
  EXPECT_GT(dihedral_angles(*fine).smallest * 180.0 / std::numbers::pi, 8.0);
  std::size_t small = 0;
  for (const auto& element : fine->elements) {
    double longest = 0.0;
    Vector3 middle = Vector3::Zero();
    for (std::size_t k = 0; k < 4; ++k) middle += 0.25 * fine->nodes[static_cast<std::size_t>(element[k])];
    for (const auto& [i, j] : kElementEdges)
      longest =
          std::max(longest, (fine->nodes[static_cast<std::size_t>(element[static_cast<std::size_t>(i)])] -
                             fine->nodes[static_cast<std::size_t>(element[static_cast<std::size_t>(j)])])
                                .norm());
    EXPECT_LE(longest, wanted(middle) * (1.0 + 1e-9));
    if (longest < 0.006) ++small;
  }
  EXPECT_GT(small, 100u);
  // Without a way onto the surface the body stays what it was.
  const auto straight = refined_mesh(*mesh, wanted);
  ASSERT_TRUE(straight);
  EXPECT_NEAR(volume(*straight) / volume(*mesh), 1.0, 1e-12);
}

TEST(RefinedMesh, AWayOntoTheSurfaceThatTurnsElementsInsideOutIsNotTaken) {
  const auto mesh = ball_of_elements(0.016);
  ASSERT_TRUE(mesh);
  const auto wanted = [](const Vector3&) { return 0.012; };
  const auto straight = refined_mesh(*mesh, wanted);
  ASSERT_TRUE(straight);
  const auto through = [](const Vector3& p) { return Vector3(2.0 * kBallMiddle - p); };
  const auto nowhere = [](const Vector3& p) { return Vector3(p.x(), p.y(), std::nan("")); };
  for (const auto& onto : std::vector<std::function<Vector3(const Vector3&)>>{through, nowhere}) {
    const auto fine = refined_mesh(*mesh, wanted, onto);
    ASSERT_TRUE(fine) << fine.error().message;
    EXPECT_TRUE(check(*fine));
    EXPECT_NEAR(volume(*fine) / volume(*straight), 1.0, 1e-12);
  }
}

TEST(RefinedMesh, WhatTakesTooManyElementsIsRefused) {
  const auto mesh = ball_of_elements(0.016);
  ASSERT_TRUE(mesh);
  const auto fine = refined_mesh(*mesh, [](const Vector3&) { return 0.0018; });
  ASSERT_FALSE(fine);
  EXPECT_NE(fine.error().message.find("200000 elements"), std::string::npos) << fine.error().message;
}

}  // namespace
}  // namespace palpate::physics::deformable
