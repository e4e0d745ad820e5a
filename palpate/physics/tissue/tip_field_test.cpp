#include "palpate/physics/tissue/tip_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "palpate/math/random_vector.h"
#include "palpate/physics/tissue/tissue_for_tests.h"
#include "tests/allocation_count.h"

namespace palpate::physics::tissue {
namespace {

const Vector3 kHalf(0.05, 0.04, 0.02);
constexpr double kDeepest = 0.006;

// The centre of the tip above (x, y), pressed `depth` into the block's top.
Vector3 centre_at(double x, double y, double depth, const SoftForTests& soft) {
  return {x, y, kHalf.z() + soft.radius - depth};
}

const TipField& plain_block() {
  static const TipField field = *block_for_tests({});
  return field;
}

const SoftForTests& nodular() {
  static const SoftForTests soft{.share = bump_for_tests({0.01, -0.005, kHalf.z()}, 0.45, 0.008)};
  return soft;
}
const TipField& nodular_block() {
  static const TipField field = *block_for_tests(nodular());
  return field;
}

TEST(TipField, OnAFlatItGivesTheForceOfTheSites) {
  const SoftForTests soft;
  Random random(1, "tissue/flat");
  for (int i = 0; i < 2000; ++i) {
    const double d = random.uniform(0.0002, 0.006), x = random.uniform(-0.035, 0.035),
                 y = random.uniform(-0.025, 0.025);
    const TipEnergy found = plain_block().at(centre_at(x, y, d, soft));
    const double expected = soft.force(Vector3::Zero(), d);
    constexpr double kDepthOff = 1e-6;  // m: what the ends of the exact distances leave
    const double tangent = soft.tangent(Vector3::Zero(), d), energy = soft.energy(Vector3::Zero(), d);
    ASSERT_NEAR(found.depth, d, kDepthOff);
    EXPECT_NEAR(found.force.z(), expected, 2e-3 * expected + kDepthOff * tangent + 1e-6) << d;
    EXPECT_LT(found.force.head<2>().norm(), 1e-3 * expected + 1e-6);
    EXPECT_NEAR(found.energy, energy, 2e-3 * energy + kDepthOff * expected + 1e-9);
    EXPECT_NEAR(found.tangent, tangent, 0.05 * tangent);
    EXPECT_FALSE(found.lost);
  }
}

TEST(TipField, SlidingOverAHomogeneousFlatTheForceRipplesLessThanHalfAPercent) {
  const SoftForTests soft;
  for (const double d : {0.001, 0.003, 0.005}) {
    double low = 1e9, high = 0.0;
    for (double s = -0.03; s < 0.03; s += 0.00001) {
      const double f = plain_block().at(centre_at(s, 0.61 * s, d, soft)).force.norm();
      low = std::min(low, f);
      high = std::max(high, f);
    }
    EXPECT_LT((high - low) / high, 0.005) << d;
  }
}

// A bump of a third of the sites' distance again as wide: what lies between the sites is a matter of the blend.
TEST(TipField, BetweenSitesItFollowsWhatVariesOverTheSurface) {
  const SoftForTests& soft = nodular();
  Random random(2, "tissue/bump");
  double square = 0.0, worst = 0.0;
  constexpr int kTimes = 4000;
  for (int i = 0; i < kTimes; ++i) {
    const double d = random.uniform(0.001, 0.006), x = random.uniform(-0.03, 0.035),
                 y = random.uniform(-0.028, 0.022);
    const double expected = soft.force({x, y, kHalf.z()}, d);
    const double off = nodular_block().at(centre_at(x, y, d, soft)).force.z() / expected - 1.0;
    square += off * off / kTimes;
    worst = std::max(worst, std::abs(off));
  }
  EXPECT_LT(std::sqrt(square), 0.006);
  EXPECT_LT(worst, 0.03);
}

TEST(TipField, AtTheSitesItGivesWhatWasComputedThere) {
  const SoftForTests& soft = nodular();
  for (const EnergySite& site : box_sites_for_tests(kHalf, soft, 0.007, kDeepest)) {
    const Vector3 inside = kHalf - site.place.cwiseAbs();
    if (site.normal.z() < 0.5 || inside.head<2>().minCoeff() < 0.012) continue;
    for (const double d : {0.0015, 0.003, 0.0055}) {
      const TipEnergy found = nodular_block().at(site.place + (soft.radius - d) * site.normal);
      EXPECT_NEAR(found.force.z() / soft.force(site.place, d), 1.0, 0.005) << site.place.transpose();
    }
  }
}

TEST(TipField, TheForceIsTheGradientOfTheEnergy) {
  Random random(3, "tissue/energy gradient");
  int pressed = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vector3 p = uniform3(random, 1.0).cwiseProduct(kHalf + Vector3::Constant(0.008));
    const TipEnergy here = nodular_block().at(p);
    if (here.depth <= 1e-5) continue;
    ++pressed;
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Vector3 step = 1e-7 * Vector3::Unit(k);
      const double slope = (nodular_block().at(p + step).energy - nodular_block().at(p - step).energy) / 2e-7;
      EXPECT_NEAR(here.force[k], -slope, 1e-6 + 1e-5 * here.force.norm());
    }
  }
  EXPECT_GT(pressed, 1000);
}

TEST(TipField, OutsideThereIsNothingToTheLastBit) {
  Random random(4, "tissue/outside");
  const Vector3 reach = kHalf + Vector3::Constant(0.008 + 1e-5);
  int outside = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vector3 p = uniform3(random, 0.09);
    const Vector3 over = (p.cwiseAbs() - kHalf).cwiseMax(0.0);
    if (over.norm() < 0.008 + 1e-4) continue;
    ++outside;
    const TipEnergy found = nodular_block().at(p);
    ASSERT_EQ(found.energy, 0.0);
    ASSERT_EQ(found.force, Vector3::Zero());
  }
  EXPECT_GT(outside, 5000);
  for (const Vector3& p : {Vector3(reach), Vector3(1e300, 0, 0), Vector3(std::nan(""), 0, 0),
                           Vector3(0, -std::numeric_limits<double>::infinity(), 0)})
    EXPECT_EQ(nodular_block().at(p).force, Vector3::Zero());
}

// Closed paths of random shape through the flat, the bump, the edges and the air above; work summed by the
// trapezoidal rule, which is of high order on closed smooth paths.
TEST(TipField, AroundAThousandClosedPathsNoWorkIsDone) {
  Random random(5, "tissue/loops");
  double worst = 0.0;
  for (int loop = 0; loop < 1000; ++loop) {
    const bool edge = loop % 4 == 0;
    const Vector3 middle = centre_at(edge ? 0.05 : random.uniform(-0.03, 0.03), random.uniform(-0.02, 0.02),
                                     random.uniform(0.001, 0.004), {});
    std::array<Vector3, 6> amplitude;
    for (auto& a : amplitude) a = uniform3(random, 1.0).cwiseProduct(Vector3(0.006, 0.006, 0.0012));
    constexpr int kPoints = 8000;
    double work = 0.0, stored = 0.0;
    for (int i = 0; i < kPoints; ++i) {
      const double t = 2.0 * M_PI * i / kPoints;
      Vector3 p = middle, velocity = Vector3::Zero();
      for (std::size_t k = 0; k < 3; ++k) {
        const double n = static_cast<double>(k + 1);
        p += (std::cos(n * t) * amplitude[2 * k] + std::sin(n * t) * amplitude[2 * k + 1]) / n;
        velocity += std::cos(n * t) * amplitude[2 * k + 1] - std::sin(n * t) * amplitude[2 * k];
      }
      const TipEnergy found = nodular_block().at(p);
      work += found.force.dot(velocity) * 2.0 * M_PI / kPoints;
      stored = std::max(stored, found.energy);
    }
    if (stored > 1e-7) worst = std::max(worst, std::abs(work) / stored);
  }
  EXPECT_LT(worst, 1e-6);
}

TEST(TipField, ABodyThatIsTooStiffIsRefusedInWords) {
  // At which it is as stiff as is allowed; corners sharper than the spacing count, too.
  const double young = SoftForTests{}.young * kMostTangent_n_m / plain_block().facts().stiffest_n_m;
  EXPECT_LT(young, 0.98 * young_for_tests(kMostTangent_n_m, kDeepest));
  EXPECT_TRUE(block_for_tests({.young = 0.99 * young}).has_value());
  const auto stiff = block_for_tests({.young = 1.01 * young});
  ASSERT_FALSE(stiff.has_value());
  EXPECT_NE(stiff.error().message.find("choose a softer material, a smaller tip or less depth"),
            std::string::npos)
      << stiff.error().message;
}

TEST(TipField, KnowsItsStiffestAndItsStrongest) {
  const SoftForTests soft;
  const TipFieldFacts& facts = plain_block().facts();
  // At the box's corners, which no lattice of this spacing resolves, it is up to 1.4 times as stiff.
  EXPECT_GE(facts.stiffest_n_m, 0.97 * soft.tangent(Vector3::Zero(), kDeepest));
  EXPECT_LE(facts.stiffest_n_m, 1.45 * soft.tangent(Vector3::Zero(), kDeepest));
  EXPECT_NEAR(facts.strongest_n, 1.7 * soft.force(Vector3::Zero(), kDeepest),
              0.2 * soft.force(Vector3::Zero(), kDeepest));
}

TEST(TipField, BeyondItsDeepestTheStiffnessStaysAndThenTheTipIsLost) {
  const SoftForTests soft;
  const double most = soft.force(Vector3::Zero(), kDeepest);
  for (double d = 1.1 * kDeepest; d < 1.45 * kDeepest; d += 0.0001) {
    const TipEnergy found = plain_block().at(centre_at(0.003, 0.001, d, soft));
    const double expected = most + (d - kDeepest) * soft.tangent(Vector3::Zero(), kDeepest);
    EXPECT_NEAR(found.force.z(), expected, 0.01 * expected) << d;
    EXPECT_FALSE(found.lost) << d;
  }
  EXPECT_TRUE(plain_block().at(centre_at(0.003, 0.001, 1.51 * kDeepest, soft)).lost);
  EXPECT_TRUE(plain_block().at(Vector3::Zero()).lost) << "in its middle";
}

// A sheet thinner than the tip: where the force begins to turn to the other side the tip is lost.
TEST(TipField, PressedThroughAThinSheetTheTipIsLostBeforeTheForceTurns) {
  const SoftForTests soft{.radius = 0.003};
  const Vector3 half(0.03, 0.03, 0.005);
  const auto field = block_for_tests(soft, half, 0.01);
  ASSERT_TRUE(field.has_value()) << field.error().message;
  bool lost = false;
  for (double z = half.z() + 0.002; z > -half.z(); z -= 1e-5) {
    const TipEnergy found = field->at({0.001, 0.002, z});
    lost = lost || found.lost;
    if (!lost) {
      EXPECT_GT(found.force.z(), 0.0) << z;
    }
    if (z < 0.0) {
      EXPECT_TRUE(lost);
    }
  }
}

TEST(TipField, OnARoundBodyTheForceIsAlongTheSurfacesNormal) {
  const double radius = 0.03;
  const SoftForTests soft{.radius = 0.005};
  const auto mesh = scene::sphere_mesh(radius, 48, 96);
  std::vector<EnergySite> sites;
  for (int i = 0; i < 400; ++i) {  // a spiral over the sphere
    const double z = 1.0 - (2.0 * i + 1.0) / 400.0, turn = 2.399963 * i, r = std::sqrt(1.0 - z * z);
    const Vector3 n(r * std::cos(turn), r * std::sin(turn), z);
    sites.push_back(soft.site(radius * n, n, kDeepest));
  }
  const auto field = TipField::build(mesh, sites, {.tip_radius = soft.radius});
  ASSERT_TRUE(field.has_value()) << field.error().message;
  Random random(6, "tissue/round");
  for (int i = 0; i < 500; ++i) {
    const Vector3 n = normal3(random).normalized();
    const double d = random.uniform(0.001, 0.0055);
    const TipEnergy found = field->at((radius + soft.radius - d) * n);
    EXPECT_NEAR(found.depth, d, 1e-4) << "chords of the mesh";
    EXPECT_LT(std::acos(std::min(1.0, found.force.normalized().dot(n))), 3.0 * M_PI / 180.0);
    EXPECT_NEAR(found.force.norm() / soft.force(Vector3::Zero(), found.depth), 1.0, 0.02);
  }
}

TEST(TipField, WhatMakesNoSenseIsRefusedInWords) {
  const SoftForTests soft;
  const auto mesh = scene::box_mesh(-kHalf, kHalf);
  auto sites = box_sites_for_tests(kHalf, soft, 0.02, kDeepest);
  const auto words = [&](const TipFieldSettings& settings) {
    const auto field = TipField::build(mesh, sites, settings);
    return field ? std::string() : field.error().message;
  };
  EXPECT_EQ(words({.tip_radius = 0.008}), "");
  EXPECT_NE(words({.tip_radius = std::nan("")}).find("a tip of nan m"), std::string::npos);
  EXPECT_NE(words({.tip_radius = 0.008, .spacing = 1e-4}).find("choose a larger spacing"), std::string::npos);
  EXPECT_NE(words({.tip_radius = 0.008, .deepest = 0.007}).find("end at 6.00 mm"), std::string::npos);
  auto good = sites;
  sites[3].energy_j[2] = sites[3].energy_j[1];
  EXPECT_NE(words({.tip_radius = 0.008}).find("site 3: entry 2"), std::string::npos);
  sites = good;
  sites[5].normal *= 2.0;
  EXPECT_NE(words({.tip_radius = 0.008}).find("site 5"), std::string::npos);
  sites.clear();
  EXPECT_NE(words({.tip_radius = 0.008}).find("no sites"), std::string::npos);
}

TEST(TipField, ItsKeyChangesWithAllThatItIsMadeOf) {
  const SoftForTests soft;
  auto mesh = scene::box_mesh(-kHalf, kHalf);
  auto sites = box_sites_for_tests(kHalf, soft, 0.02, kDeepest);
  const std::string key = tip_field_key(mesh, sites, {});
  EXPECT_EQ(key, tip_field_key(mesh, sites, {}));
  EXPECT_NE(key, tip_field_key(mesh, sites, {.tip_radius = 0.006}));
  EXPECT_NE(key, tip_field_key(mesh, sites, {.spacing = 0.9 * TipFieldSettings{}.spacing}));
  EXPECT_NE(key, tip_field_key(mesh, sites, {.deepest = 0.005}));
  std::swap(mesh.triangles[0], mesh.triangles[1]);
  EXPECT_NE(key, tip_field_key(mesh, sites, {}));
  std::swap(mesh.triangles[0], mesh.triangles[1]);
  sites[7].normal *= -1.0;
  EXPECT_NE(key, tip_field_key(mesh, sites, {}));
  sites[7].normal *= -1.0;
  sites[7].depth_m[4] *= 1.0 + 1e-15;
  EXPECT_NE(key, tip_field_key(mesh, sites, {}));
  sites = box_sites_for_tests(kHalf, soft, 0.02, kDeepest);
  sites[7].energy_j[4] *= 1.0 + 1e-15;
  EXPECT_NE(key, tip_field_key(mesh, sites, {}));
  sites = box_sites_for_tests(kHalf, soft, 0.02, kDeepest);
  mesh.vertices[1].x() += 1e-12;
  EXPECT_NE(key, tip_field_key(mesh, sites, {}));
}

TEST(TipField, ATickAllocatesNothing) {
  const TipField& field = nodular_block();
  const std::size_t before = allocations();
  double sum = 0.0;
  for (int i = 0; i < 100; ++i) sum += field.at(centre_at(1e-4 * i, 0.0, 0.003, {})).force.z();
  EXPECT_EQ(allocations() - before, 0u);
  EXPECT_GT(sum, 0.0);
}

}  // namespace
}  // namespace palpate::physics::tissue
