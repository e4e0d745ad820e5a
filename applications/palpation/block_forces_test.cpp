// Forces on the block against tables of independent solvers (docs/theory/deformable.md): axisymmetric finite elements for the
// middle, a substructured mesh for places beside.
#include "applications/palpation/block_forces.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate::applications::palpation {
namespace {

struct Known {
  double depth_mm, bare, over;  // N, without and above a ball of 15 mm, its top 5 mm deep, 10 times stiffer
};

void expect_near_table(BlockMatter matter, std::initializer_list<Known> table, double tolerance) {
  const std::vector<BlockNodule> nodules(1);
  const auto curves = forces_on_block(nodules, matter);
  ASSERT_TRUE(curves) << curves.error().message;
  const ForceCurve &bare = curves->at(0), &over = curves->at(1);
  for (const auto& known : table) {
    const double depth = 1e-3 * known.depth_mm;
    EXPECT_NEAR(bare.at(depth) / known.bare, 1.0, tolerance) << known.depth_mm;
    EXPECT_NEAR(over.at(depth) / known.over, 1.0, tolerance) << known.depth_mm;
  }
}

TEST(BlockForces, TickIsThatOfTheIndependentNeoHookeanTable) {
  expect_near_table(
      BlockMatter::neo_hookean,
      {{2.0, 0.08366, 0.1145}, {3.0, 0.1537, 0.2143}, {4.0, 0.2358, 0.3314}, {5.0, 0.3273, 0.4623}}, 0.05);
}

TEST(BlockForces, LinearMatterIsThatOfTheIndependentLinearTable) {
  expect_near_table(
      BlockMatter::linear,
      {{2.0, 0.08168, 0.1011}, {3.0, 0.1456, 0.1761}, {4.0, 0.2150, 0.2522}, {5.0, 0.2845, 0.3225}}, 0.05);
}

TEST(BlockForces, ContrastBesideANoduleIsThatOfAFullSolution) {
  const std::vector<BlockNodule> nodules(1);
  const auto profiles = contrast_profiles(nodules, 6);
  ASSERT_TRUE(profiles) << profiles.error().message;
  const double known[] = {1.41, 1.36, 1.21, 1.09, 1.03, 1.01};
  for (std::size_t k = 0; k < 6; ++k)
    EXPECT_NEAR(std::exp(profiles->front().contrasts()[k]), known[k], 0.04) << 4 * k << " mm beside";
}

TEST(BlockForces, ACurveIsHertzBetweenItsDepthsAndScales) {
  const ForceCurve curve({0.001, 0.004}, {2.0 * std::pow(0.001, 1.5), 2.0 * std::pow(0.004, 1.5)});
  EXPECT_NEAR(curve.at(0.0025), 2.0 * std::pow(0.0025, 1.5), 1e-12);
  EXPECT_NEAR(curve.at(0.0004), 2.0 * std::pow(0.0004, 1.5), 1e-12);
  EXPECT_NEAR(curve.times(3.0).at(0.002) / curve.at(0.002), 3.0, 1e-12);
  EXPECT_EQ(curve.at(-0.001), 0.0);
  EXPECT_THROW(ForceCurve({0.002, 0.001}, {1.0, 2.0}), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::applications::palpation
