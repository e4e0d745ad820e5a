#include "palpate/physics/tissue/site_blend.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate::physics::tissue {
namespace {

constexpr double kDepths[] = {0.5e-3, 1.0e-3, 2.0e-3, 3.5e-3, 5.0e-3};

double power_25(double d) { return d * d * std::sqrt(d); }

// A site at which kappa is the parabola c0 + c1 d + c2 d^2 of the depth.
EnergySite site_at(const Vector3& place, const Vector3& normal, double c0, double c1 = 0.0, double c2 = 0.0) {
  EnergySite site{place, normal, {}, {}};
  for (const double d : kDepths) {
    site.depth_m.push_back(d);
    site.energy_j.push_back((c0 + c1 * d + c2 * d * d) * power_25(d));
  }
  return site;
}

SiteBlend blend_of(const std::vector<EnergySite>& sites, double deepest = 0.0, double shallowest = 0.0) {
  auto blend = SiteBlend::of(sites, deepest, shallowest);
  EXPECT_TRUE(blend) << blend.error().message;
  return *blend;
}

TEST(SiteBlend, AParabolaOverDepthComesBackBetweenTheEntries) {
  constexpr double c0 = 1e5, c1 = 4e6, c2 = -3e8;
  const auto blend = blend_of({site_at(Vector3::Zero(), Vector3::UnitZ(), c0, c1, c2)});
  EXPECT_EQ(blend.deepest(), 5e-3);
  for (double d = 0.5e-3; d <= 5e-3; d += 0.1e-3)
    EXPECT_NEAR(blend.kappa(Vector3::Zero(), Vector3::UnitZ(), d), c0 + c1 * d + c2 * d * d, 1e-9 * c0) << d;
  // Below the first entry a straight line.
  const double slope = c1 + 2.0 * c2 * kDepths[0],
               first = c0 + c1 * kDepths[0] + c2 * kDepths[0] * kDepths[0];
  EXPECT_NEAR(blend.kappa(Vector3::Zero(), Vector3::UnitZ(), 0.2e-3), first - slope * 0.3e-3, 1e-9 * c0);
}

TEST(SiteBlend, FartherOutThanItsLeastDepthItIsAsThere) {
  const auto blend = blend_of({site_at(Vector3::Zero(), Vector3::UnitZ(), 1e5, 4e6)}, 0.0, 0.3e-3);
  const auto kappa = [&](double d) { return blend.kappa(Vector3::Zero(), Vector3::UnitZ(), d); };
  EXPECT_EQ(kappa(0.1e-3), kappa(0.3e-3));
  EXPECT_NE(kappa(0.4e-3), kappa(0.3e-3));
}

// Beyond what was asked for, not beyond the table: the stiffness stays as it is there.
TEST(SiteBlend, BelowItsDeepestTheStiffnessStays) {
  constexpr double kDeepest = 3e-3;
  const auto blend = blend_of({site_at(Vector3::Zero(), Vector3::UnitZ(), 1e5)}, kDeepest);
  EXPECT_EQ(blend.deepest(), kDeepest);
  const auto energy = [&](double d) {
    return blend.kappa(Vector3::Zero(), Vector3::UnitZ(), d) * power_25(d);
  };
  constexpr double h = 1e-4;
  const double tangent = 3.75 * 1e5 * std::sqrt(kDeepest);
  for (const double d : {3.2e-3, 4e-3, 7e-3})
    EXPECT_NEAR((energy(d + h) - 2.0 * energy(d) + energy(d - h)) / (h * h), tangent, 1e-3 * tangent) << d;
  const auto deeper =
      SiteBlend::of(std::vector<EnergySite>{site_at(Vector3::Zero(), Vector3::UnitZ(), 1e5)}, 6e-3, 0.0);
  ASSERT_FALSE(deeper);
  EXPECT_NE(deeper.error().message.find("end at 5.00 mm"), std::string::npos) << deeper.error().message;
}

TEST(SiteBlend, MidwayBetweenTwoSitesItIsTheirMean) {
  const auto blend =
      blend_of({site_at({-0.01, 0, 0}, Vector3::UnitZ(), 1e5), site_at({0.01, 0, 0}, Vector3::UnitZ(), 3e5)});
  EXPECT_NEAR(blend.kappa(Vector3::Zero(), Vector3::UnitZ(), 2e-3), 2e5, 1.0);
}

// The other side of a rim is as near as this one, and another tissue.
TEST(SiteBlend, SitesThatFaceElsewhereHardlyCount) {
  std::vector<EnergySite> sites;
  for (const double x : {-0.01, 0.0, 0.01})
    for (const double y : {-0.01, 0.0, 0.01}) {
      sites.push_back(site_at({x, y, 0.001}, Vector3::UnitZ(), 1e5 * (1.0 + 20.0 * x)));
      sites.push_back(site_at({x + 1e-3, y, -0.001}, -Vector3::UnitZ(), 5e5));
    }
  EXPECT_NEAR(blend_of(sites).kappa({0.002, 0.003, 0.001}, Vector3::UnitZ(), 2e-3), 1.04e5, 2e3);
}

TEST(SiteBlend, AQuadraticAlongTheSurfaceIsFollowedAndDoesNotRunAwayBesideIt) {
  const auto truth = [](double x, double y) { return 1e5 * (1.0 + 20.0 * x - 10.0 * y + 900.0 * x * x); };
  std::vector<EnergySite> sites;
  double high = 0.0, low = 1e9;
  for (int i = -4; i <= 4; ++i)
    for (int k = -4; k <= 4; ++k) {
      const double x = 4e-3 * i, y = 4e-3 * k;
      sites.push_back(site_at({x, y, 0}, Vector3::UnitZ(), truth(x, y)));
      high = std::max(high, truth(x, y)), low = std::min(low, truth(x, y));
    }
  const auto blend = blend_of(sites);
  for (const auto& [x, y] : {std::pair{1e-3, 2e-3}, {-5e-3, 3e-3}, {6e-3, -7e-3}})
    EXPECT_NEAR(blend.kappa({x, y, 0}, Vector3::UnitZ(), 2e-3), truth(x, y), 1e-3 * truth(x, y));
  const double beside = blend.kappa({0.06, 0.0, 0}, Vector3::UnitZ(), 2e-3);
  EXPECT_GT(truth(0.06, 0.0), 1.5 * high);
  EXPECT_LE(beside, high + 0.5 * (high - low));
}

// As many at one distance as it looks at: each would come in with no weight.
TEST(SiteBlend, OnARingOfSitesItIsThatOfTheNearest) {
  std::vector<EnergySite> sites;
  for (const Vector3& p : {Vector3(5, 0, 0), Vector3(4, 3, 0), Vector3(0, 3, 4), Vector3(0, 4, 3),
                           Vector3(3, 0, 4), Vector3(4, 0, 3), Vector3(3, 4, 0)})
    for (const double a : {-1.0, 1.0})
      for (const double b : {-1.0, 1.0})
        sites.push_back(site_at(a * Vector3(p.x(), b * p.y(), p.z()), Vector3::UnitZ(), 1e5));
  EXPECT_NEAR(blend_of(sites).kappa(Vector3::Zero(), Vector3::UnitZ(), 2e-3), 1e5, 1e-6);
}

}  // namespace
}  // namespace palpate::physics::tissue
