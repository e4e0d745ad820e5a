#include "applications/palpation/liver.h"

#include <gtest/gtest.h>

#include <map>

#include "applications/palpation/nodules.h"
#include "applications/palpation/organ_for_tests.h"
#include "palpate/physics/tissue/surface_distance.h"

namespace palpate::applications::palpation {
namespace {

TEST(Liver, IsClosedTurnedOutwardsAndOfTheSizeItSays) {
  const auto mesh = liver_mesh();
  EXPECT_GE(mesh.vertices.size(), 10'000u);
  EXPECT_NEAR(volume_of(mesh), 390e-6, 10e-6);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  for (const auto& [edge, count] : edges) {
    ASSERT_EQ(count, 1);
    ASSERT_EQ(edges.count({edge.second, edge.first}), 1u) << "the neighbour goes the other way";
  }
  // Euler's formula of a sphere.
  EXPECT_EQ(mesh.vertices.size() + mesh.triangles.size() - edges.size() / 2, 2u);
}

TEST(Liver, LiesFlatOnTheTableAndIsSmoothAbove) {
  const auto mesh = liver_mesh();
  const auto normals = vertex_normals(mesh);
  double flat = 0.0;
  for (const auto& v : mesh.vertices) {
    ASSERT_GE(v.y(), 0.0);
    flat += v.y() == 0.0 ? 1.0 : 0.0;
  }
  EXPECT_GT(flat / static_cast<double>(mesh.vertices.size()), 0.2);
  for (const auto& t : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      ASSERT_GT(normals[t[k]].dot(normals[t[(k + 1) % 3]]), 0.8) << "of neighbours";
}

TEST(Nodules, LieAsDeepAsDrawnInsideApartAndInTheSearchedArea) {
  const auto mesh = liver_mesh(13);
  const auto surface = physics::tissue::SurfaceDistance::of(mesh).value();
  const SearchArea area = search_area(mesh);
  const NoduleRanges ranges{.fewest = 1, .most = 3};
  std::array<int, 4> counts{};
  for (int trial = 1; trial <= 40; ++trial) {
    const auto nodules = draw_nodules(mesh, ranges, 0.010, trial_seed(7, trial));
    ASSERT_TRUE(nodules) << nodules.error().message;
    ASSERT_LE(nodules->size(), 3u);
    ++counts[nodules->size()];
    for (std::size_t i = 0; i < nodules->size(); ++i) {
      const auto& nodule = (*nodules)[i];
      const double depth = -surface.at(nodule.ball.centre).distance - nodule.ball.radius;
      EXPECT_GT(depth, ranges.depth[0] - 0.001);
      EXPECT_LT(depth, ranges.depth[1] + 1e-9);
      EXPECT_TRUE(area.holds(nodule.above.x(), nodule.above.z()));
      for (std::size_t k = 0; k < i; ++k) EXPECT_GT((nodule.above - (*nodules)[k].above).norm(), 0.020);
    }
  }
  for (const int count : {1, 2, 3}) EXPECT_GT(counts[static_cast<std::size_t>(count)], 4) << count;
  EXPECT_EQ(counts[0], 0);
}

TEST(Nodules, AreTheSameForTheSameSeedAndOthersForAnother) {
  const auto mesh = liver_mesh(13);
  const auto first = draw_nodules(mesh, {}, 0.010, 5).value(),
             again = draw_nodules(mesh, {}, 0.010, 5).value(),
             other = draw_nodules(mesh, {}, 0.010, 6).value();
  ASSERT_EQ(first.size(), again.size());
  EXPECT_EQ(first[0].above, again[0].above);
  EXPECT_NE(first[0].above, other[0].above);
  EXPECT_NE(trial_seed(1, 1), trial_seed(1, 2));
  EXPECT_NE(trial_seed(1, 1), trial_seed(2, 1));
}

TEST(Nodules, WhatDoesNotFitIsRefusedInWords) {
  const auto large = draw_nodules(liver_mesh(13), {.diameter = {0.08, 0.09}}, 0.010, 1);
  ASSERT_FALSE(large);
  EXPECT_NE(large.error().message.find("choose fewer, smaller or shallower"), std::string::npos);
}

TEST(PalpationSettings, RangesTheWrongWayRoundAreComplainedOf) {
  auto values = scene::SettingValues(setting_schema());
  EXPECT_TRUE(scene::check(setting_schema(), values));
  values.set("palpation.nodule_mm", std::vector<double>{18.0, 14.0});
  EXPECT_FALSE(scene::check(setting_schema(), values));
  values.set("palpation.nodule_mm", std::vector<double>{14.0, 18.0});
  values.set("palpation.nodules", std::vector<double>{0.5, 2.0});
  EXPECT_FALSE(scene::check(setting_schema(), values));
}

TEST(PalpationSettings, TravelAsThePayload) {
  const auto scene = with(table_for_tests(), "palpation.young_kpa", std::vector<double>{3.0});
  const PalpationSettings s = palpation_settings(scene);
  EXPECT_EQ(s.young_pa, 3000.0);
  EXPECT_EQ(s.tip_radius, 0.006);
  EXPECT_EQ(s.nodules.most, 2);
  EXPECT_TRUE(s.trainee.senses);
}

}  // namespace
}  // namespace palpate::applications::palpation
