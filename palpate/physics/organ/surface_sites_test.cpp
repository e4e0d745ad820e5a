// Sites on a dome: how near they lie, how well they cover it, and what they leave out.
#include "palpate/physics/organ/surface_sites.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::physics::organ {
namespace {

TEST(SurfaceSites, CoverWhatCanBeReachedEvenly) {
  const scene::TriangleMesh ball = scene::sphere_mesh(0.04, 40, 80);
  constexpr double kSpacing = 0.007, kSupport = 0.02;
  const auto distance = tissue::SurfaceDistance::of(ball);
  ASSERT_TRUE(distance) << distance.error().message;
  const auto sites = surface_sites(ball, *distance, kSpacing, Vector3::UnitY(), kSupport);
  const auto nearest = [&](const Vector3& p, bool itself) {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& site : sites)
      if (const double d = (site.place - p).norm(); d > 0.0 || !itself) least = std::min(least, d);
    return least;
  };
  for (const auto& site : sites) {
    EXPECT_GT(site.place.y(), -0.04 + kSupport);
    EXPECT_GT(site.normal.y(), -0.3);
    EXPECT_GT(site.normal.dot(site.place.normalized()), 0.99);
    EXPECT_GE(nearest(site.place, true), 0.84 * kSpacing);
  }
  for (const Vector3& v : ball.vertices)
    if (v.y() > -0.04 * 0.29) {
      EXPECT_LE(nearest(v, false), 0.95 * kSpacing) << v.transpose();
    }
  // The ball's zone above, and a square of the spacing for each.
  const double squares = 2.0 * 3.14159 * 0.04 * 0.04 * 1.3 / (kSpacing * kSpacing);
  EXPECT_NEAR(static_cast<double>(sites.size()) / squares, 1.0, 0.12);
  const auto again = surface_sites(ball, *distance, kSpacing, Vector3::UnitY(), kSupport);
  ASSERT_EQ(again.size(), sites.size());
  EXPECT_EQ(again.back().place, sites.back().place);
}

// A ball with a waist about x.
TEST(SurfaceSites, LieCloserWhereTheSurfaceIsHollow) {
  scene::TriangleMesh waist = scene::sphere_mesh(0.04, 60, 120);
  constexpr double kSpacing = 0.007, kWide = 0.012;
  for (Vector3& v : waist.vertices) {
    const double in = 1.0 - 0.25 * std::exp(-v.x() * v.x() / (kWide * kWide));
    v.y() *= in, v.z() *= in;
  }
  const auto distance = tissue::SurfaceDistance::of(waist);
  ASSERT_TRUE(distance) << distance.error().message;
  const auto sites = surface_sites(waist, *distance, kSpacing, Vector3::UnitY(), 0.02);
  int within = 0, beyond = 0;
  for (const auto& site : sites) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& other : sites)
      if (const double d = (other.place - site.place).norm(); d > 0.0) nearest = std::min(nearest, d);
    EXPECT_GE(nearest, 0.42 * kSpacing);
    const double x = std::abs(site.place.x());
    if (x < 0.004 && site.place.y() > 0.01) {
      ++within;
      EXPECT_LT(nearest, 0.7 * kSpacing) << site.place.transpose();
    } else if (x > 0.032) {
      ++beyond;
      EXPECT_GE(nearest, 0.84 * kSpacing) << site.place.transpose();
    }
  }
  EXPECT_GT(within, 20);
  EXPECT_GT(beyond, 5);
}

}  // namespace
}  // namespace palpate::physics::organ
