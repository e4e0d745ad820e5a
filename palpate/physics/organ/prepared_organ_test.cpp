// A small dome with a ball in it: the tick against the full neo-Hookean solution, the dent, the cache, what is refused.
#include "palpate/physics/organ/prepared_organ.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/file.h"
#include "palpate/core/log.h"
#include "palpate/physics/deformable/quick_indentation.h"
#include "palpate/physics/organ/full_press.h"
#include "palpate/physics/organ/organ_cache.h"
#include "palpate/physics/tissue/surface_distance.h"
#include "tests/scratch_folder.h"

namespace palpate::physics::organ {
namespace {

// Half axes 35, 30 (up) and 30 mm, below it 5.
scene::TriangleMesh small_dome() {
  scene::TriangleMesh mesh = scene::sphere_mesh(1.0, 30, 60);
  for (Vector3& v : mesh.vertices)
    v = Vector3(0.035 * v.x(), (v.y() > 0.0 ? 0.03 : 0.005) * v.y(), 0.03 * v.z());
  return mesh;
}

OrganSettings coarse_settings() {
  OrganSettings settings;
  settings.element = 0.012;
  settings.site_spacing = 0.009;
  return settings;
}

// Its top is 9 mm deep.
const Nodule kBall{{0.0, 0.0135, 0.0}, 0.0075, 10.0};

deformable::SurfaceSite place_on(const scene::TriangleMesh& surface, const Vector3& towards) {
  const auto distance = tissue::SurfaceDistance::of(surface);
  const auto found = distance->at(towards.cwiseProduct(Vector3(0.035, 0.03, 0.03)) / towards.norm());
  return {found.foot, found.normal};
}

tissue::TipEnergy pressed(const PreparedOrgan& organ, const deformable::SurfaceSite& site, double depth) {
  return organ.field.at(site.place + (organ.field.facts().tip_radius - depth) * site.normal);
}

void expect_like_full_solution(const PreparedOrgan& organ, const OrganSettings& settings,
                               const deformable::SurfaceSite& site, const std::vector<double>& depths,
                               double tolerance) {
  const auto full = full_press(organ.surface, settings, site, depths);
  ASSERT_TRUE(full) << full.error().message;
  for (const FullState& state : full->states) {
    const auto tick = pressed(organ, site, state.depth);
    EXPECT_NEAR(tick.depth, state.depth, 5e-5);
    EXPECT_NEAR(tick.force.norm() / state.force.norm(), 1.0, tolerance) << 1e3 * state.depth << " mm";
    EXPECT_GT(tick.force.normalized().dot(state.force.normalized()), std::cos(0.052)) << "3 degrees";
  }
}

// A block with a ball in it, by the same law on a graded mesh of its own, which is held against full solutions.
TEST(PreparedOrgan, TickOfABlockIsThatOfItsOwnGradedMesh) {
  deformable::Indentation block;
  block.size = {0.07, 0.07, 0.035};
  block.radius = 0.005;
  block.material.inclusions = {{{0.0, 0.0, -0.0145}, Vector3::Constant(0.0075), 10.0}};
  block.depths = {0.0015, 0.003, 0.0045};
  const auto known = deformable::quick_indentation(block);
  ASSERT_TRUE(known) << known.error().message;
  OrganSettings settings;
  settings.up = Vector3::UnitZ();
  settings.tip_radius = block.radius;
  settings.deepest = 0.005;
  settings.site_spacing = 0.009;
  settings.nodules = {{{0.0, 0.0, -0.0145}, 0.0075, 10.0}};
  const auto organ = prepare_organ(scene::box_mesh({-0.035, -0.035, -0.035}, {0.035, 0.035, 0.0}), settings);
  ASSERT_TRUE(organ) << organ.error().message;
  for (const auto& point : *known) {
    const auto tick = pressed(*organ, {Vector3::Zero(), Vector3::UnitZ()}, point.depth);
    EXPECT_NEAR(tick.force.norm() / point.force, 1.0, 0.04) << 1e3 * point.depth << " mm";
  }
}

// A strongly curved dome, radius 30 mm, tips of 5 mm, elements that an organ has: on a slope of 40 degrees, where Hertz's
// answer for a flat place would be 6 to 9 % off.
TEST(PreparedOrgan, TickOnACurvedSlopeIsThatOfTheFullSolution) {
  OrganSettings settings;
  const auto organ = prepare_organ(small_dome(), settings);
  ASSERT_TRUE(organ) << organ.error().message;
  expect_like_full_solution(*organ, settings, place_on(organ->surface, {0.0, 0.8, 0.6}),
                            {0.0015, 0.003, 0.0045}, 0.05);
}

// Long: there, on the top and above a nodule.
TEST(PreparedOrganFullSolution, ThreePlacesThreeDepths) {
  OrganSettings settings;
  settings.nodules = {{{0.01, 0.0135, 0.0}, 0.0075, 10.0}};
  const auto organ = prepare_organ(small_dome(), settings);
  ASSERT_TRUE(organ) << organ.error().message;
  for (const Vector3& towards : {Vector3(-0.3, 1.0, 0.0), Vector3(0.45, 1.0, 0.0), Vector3(0.0, 0.8, 0.6)})
    expect_like_full_solution(*organ, settings, place_on(organ->surface, towards), {0.0015, 0.003, 0.0045},
                              0.05);
}

TEST(PreparedOrgan, DentIsAsDeepAsTheTickAndTheTableHolds) {
  auto settings = coarse_settings();
  const auto organ = prepare_organ(small_dome(), settings);
  ASSERT_TRUE(organ) << organ.error().message;
  const auto site = place_on(organ->surface, {0.2, 1.0, 0.1});
  constexpr double kDepth = 0.004;
  const Vector3 tip = site.place + (settings.tip_radius - kDepth) * site.normal;
  const auto tick = organ->field.at(tip);
  std::vector<Vector3> places(organ->surface.vertices.size());
  organ->dent.press(tip, tick.depth, tick.force, places);
  double near = 0.0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Vector3& rest = organ->surface.vertices[i];
    EXPECT_GT((places[i] - tip).norm(), settings.tip_radius - 1e-9);
    if (rest.y() < -0.005 + 0.5 * settings.support) {
      EXPECT_LT((places[i] - rest).norm(), 1e-4);
    }
    // On the tip, as deep as it is there.
    if ((rest - site.place).norm() < 0.0015)
      near = std::max(near, (places[i] - tip).norm() - settings.tip_radius);
  }
  EXPECT_LT(near, 1e-4);
}

TEST(PreparedOrgan, ComesBackFromTheCacheAsItWas) {
  const ScratchFolder folder;
  auto settings = coarse_settings();
  settings.nodules = {kBall};
  settings.cache = folder.path();
  const auto surface = small_dome();
  const auto first = prepare_organ(surface, settings);
  ASSERT_TRUE(first) << first.error().message;
  EXPECT_FALSE(first->from_cache);
  const auto second = prepare_organ(surface, settings);
  ASSERT_TRUE(second);
  EXPECT_TRUE(second->from_cache);
  EXPECT_EQ(first->field.fields().coefficients(), second->field.fields().coefficients());
  EXPECT_EQ(first->dent.table().rest.moved, second->dent.table().rest.moved);
  EXPECT_EQ(first->dent.table().rest.own, second->dent.table().rest.own);

  // Another nodule: the body's own part is known, and the result is what it is without a cache.
  settings.nodules[0].centre.x() = 0.008;
  bool whole_body = false;
  const auto moved = prepare_organ(surface, settings, [&](std::string_view what, double share) {
    whole_body = whole_body || (what == "body" && share > 0.06);
    return true;
  });
  ASSERT_TRUE(moved);
  EXPECT_FALSE(moved->from_cache);
  EXPECT_FALSE(whole_body);
  EXPECT_NE(first->field.fields().coefficients(), moved->field.fields().coefficients());
}

TEST(PreparedOrgan, IsGivenUpWhereverItIs) {
  const ScratchFolder folder;
  auto settings = coarse_settings();
  settings.nodules = {kBall};
  settings.cache = folder.path();
  for (const double until : {0.0, 0.06, 0.42, 0.6}) {
    double reached = 0.0;
    const auto organ = prepare_organ(small_dome(), settings, [&](std::string_view, double share) {
      reached = share;
      return share < until;
    });
    ASSERT_FALSE(organ) << until;
    EXPECT_EQ(organ.error().message, "organ: stopped before it was ready; start it again");
    EXPECT_LT(reached, until + 0.25);  // soon
  }
  // Nothing half is kept.
  const auto organ = prepare_organ(small_dome(), settings);
  ASSERT_TRUE(organ) << organ.error().message;
  EXPECT_FALSE(organ->from_cache);
}

TEST(PreparedOrgan, DamagedCacheIsSaidAndComputedAnew) {
  const ScratchFolder folder;
  auto settings = coarse_settings();
  settings.cache = folder.path();
  const auto surface = small_dome();
  const auto first = prepare_organ(surface, settings);
  ASSERT_TRUE(first);
  for (const auto& file : std::filesystem::directory_iterator(folder.path())) {
    auto bytes = read_file(file.path());
    ASSERT_TRUE(bytes);
    (*bytes)[bytes->size() / 2] ^= 1;
    ASSERT_TRUE(write_file(file.path(), *bytes));
  }
  const LogCapture log;
  const auto second = prepare_organ(surface, settings);
  ASSERT_TRUE(second);
  EXPECT_FALSE(second->from_cache);
  EXPECT_NE(log.text().find("damaged"), std::string::npos);
  EXPECT_EQ(first->field.fields().coefficients(), second->field.fields().coefficients());
}

TEST(PreparedOrgan, WhatCannotBePreparedIsSaid) {
  const auto surface = small_dome();
  const auto said = [&](const scene::TriangleMesh& mesh, const OrganSettings& settings) {
    const auto organ = prepare_organ(mesh, settings);
    return organ ? std::string("prepared") : organ.error().message;
  };
  auto settings = coarse_settings();
  auto open = surface;
  open.triangles.pop_back();
  EXPECT_NE(said(open, settings).find("closed"), std::string::npos);
  settings.nodules = {{{0.0, 0.027, 0.0}, 0.005, 10.0}};
  EXPECT_NE(said(surface, settings).find("inside"), std::string::npos);
  settings = coarse_settings();
  settings.element = 0.04;
  EXPECT_NE(said(surface, settings), "prepared");
  settings = coarse_settings();
  settings.poisson = 0.5;
  EXPECT_NE(said(surface, settings).find("0.495"), std::string::npos);
  settings = coarse_settings();
  settings.support = 0.0;
  EXPECT_NE(said(surface, settings).find("table"), std::string::npos);
}

TEST(OrganCache, TableComesBackAndAnotherKeyIsRefused) {
  SiteTable table{{0.5, -2.0}, Eigen::MatrixXf::Random(6, 2)};
  const std::string key = "0123456789abcdef";
  const std::string bytes = site_table_bytes(table, key);
  const auto back = parse_site_table(bytes, key, "it");
  ASSERT_TRUE(back) << back.error().message;
  EXPECT_EQ(back->own, table.own);
  EXPECT_EQ(back->moved, table.moved);
  EXPECT_FALSE(parse_site_table(bytes, "fedcba9876543210", "it"));
  for (std::size_t cut = 0; cut < bytes.size(); cut += 7)
    EXPECT_FALSE(parse_site_table(bytes.substr(0, cut), key, "it"));
}

}  // namespace
}  // namespace palpate::physics::organ
