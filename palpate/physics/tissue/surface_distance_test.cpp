#include "palpate/physics/tissue/surface_distance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/math/random_vector.h"

namespace palpate::physics::tissue {
namespace {

SurfaceDistance distance_of(const scene::TriangleMesh& mesh) { return *SurfaceDistance::of(mesh); }

// Negative inside.
double box_distance(const Vector3& half, const Vector3& p) {
  const Vector3 q = p.cwiseAbs() - half;
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

TEST(SurfaceDistance, OfABoxIsItsClosedFormOnBothSides) {
  const Vector3 half(0.06, 0.05, 0.02);
  const auto surface = distance_of(scene::box_mesh(-half, half));
  Random random(1, "tissue/box");
  for (int i = 0; i < 3000; ++i) {
    const Vector3 p = uniform3(random, 0.08);
    const SurfacePlace place = surface.at(p);
    ASSERT_NEAR(place.distance, box_distance(half, p), 1e-12) << p.transpose();
    EXPECT_NEAR((p - place.foot).norm(), std::abs(place.distance), 1e-12);
  }
}

// Two spikes that share a vertex's neighbourhood: signs told by one face alone are wrong beside the edges.
TEST(SurfaceDistance, BesideSharpEdgesTheSideIsThatOfTheWindingNumber) {
  scene::TriangleMesh star;
  star.vertices = {{0, 0, 1}, {0.1, 0, 0}, {0, 1, 0}, {-0.1, 0.02, 0}, {0, -0.05, 0}, {0, 0, -0.3}};
  star.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}, {5, 2, 1}, {5, 3, 2}, {5, 4, 3}, {5, 1, 4}};
  const auto surface = distance_of(star);
  Random random(2, "tissue/star");
  int inside = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vector3 p = Vector3(0, 0.3, 0.3) + uniform3(random, 0.7).cwiseProduct(Vector3(0.3, 1, 1));
    double solid = 0.0;  // solid angle of all triangles (Van Oosterom and Strackee 1983)
    double nearest = 1e9;
    for (const auto& t : star.triangles) {
      const Vector3 a = star.vertices[t[0]] - p, b = star.vertices[t[1]] - p, c = star.vertices[t[2]] - p;
      solid += 2.0 * std::atan2(a.dot(b.cross(c)), a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                                                       b.dot(c) * a.norm() + c.dot(a) * b.norm());
      nearest = std::min(
          nearest,
          (closest_point({star.vertices[t[0]], star.vertices[t[1]], star.vertices[t[2]]}, p) - p).norm());
    }
    const bool within = std::abs(solid) > 6.0;
    const SurfacePlace place = surface.at(p);
    ASSERT_NEAR(std::abs(place.distance), nearest, 1e-12);
    if (nearest < 1e-9) continue;
    ASSERT_EQ(place.distance < 0.0, within) << p.transpose();
    inside += within;
  }
  EXPECT_GT(inside, 300);
}

TEST(SurfaceDistance, BeyondWhatIsAskedForItIsThat) {
  const Vector3 half(0.06, 0.05, 0.02);
  const auto surface = distance_of(scene::box_mesh(-half, half));
  EXPECT_NEAR(surface.at({0, 0, 0.016}, 0.005).distance, -0.004, 1e-15);
  EXPECT_EQ(surface.at({0, 0, 0}, 0.005).distance, 0.005);
  EXPECT_NEAR(surface.at({0, 0, 0.0249}, 0.005).distance, 0.0049, 1e-15);
}

// Each face counts by its angle at the corner (Baerentzen and Aanaes 2005), in however many triangles it is cut.
TEST(SurfaceDistance, AtACornerOfABoxItPointsAwayFromAllThreeFacesAlike) {
  const Vector3 half(0.01, 0.02, 0.03);
  const auto surface = distance_of(scene::box_mesh(-half, half));
  for (int corner = 0; corner < 8; ++corner) {
    const Vector3 away((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1, (corner & 4) != 0 ? 1 : -1);
    const SurfacePlace place = surface.at(half.cwiseProduct(away) + 0.005 * away);
    EXPECT_LT((place.normal - away.normalized()).norm(), 1e-12) << corner;
  }
}

TEST(SurfaceDistance, WhatIsNotClosedIsRefusedInWords) {
  const Vector3 half(0.01, 0.01, 0.01);
  scene::TriangleMesh open = scene::box_mesh(-half, half), turned = open, bad = open;
  open.triangles.pop_back();
  std::swap(turned.triangles[3][0], turned.triangles[3][1]);
  bad.vertices[2].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(SurfaceDistance::of(open).error().message.find("close its holes"), std::string::npos);
  EXPECT_NE(SurfaceDistance::of(turned).error().message.find("the same way"), std::string::npos);
  EXPECT_NE(SurfaceDistance::of(bad).error().message.find("not finite"), std::string::npos);
  EXPECT_FALSE(SurfaceDistance::of({}).has_value());
  scene::TriangleMesh flat = scene::box_mesh(-half, half), stray = flat;
  flat.triangles[3] = {flat.triangles[3][0], flat.triangles[3][1], flat.triangles[3][1]};
  stray.triangles[3][0] = static_cast<std::uint32_t>(stray.vertices.size());
  EXPECT_NE(SurfaceDistance::of(flat).error().message.find("no area"), std::string::npos);
  EXPECT_NE(SurfaceDistance::of(stray).error().message.find("names vertex"), std::string::npos);
}

}  // namespace
}  // namespace palpate::physics::tissue
