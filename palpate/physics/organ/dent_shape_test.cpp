// The half-space under Hertz's pressure against its integral, and a block whose rest is known.
#include "palpate/physics/organ/dent_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "palpate/physics/deformable/site_law.h"

namespace palpate::physics::organ {
namespace {

// Displacement at a distance by Boussinesq's point forces over the disc, in parts of that in the middle. Polar about
// the point itself, where the integrand is smooth.
double profile_by_integral(double s) {
  constexpr int kAngles = 4000, kSteps = 400;
  const auto pressure = [](double r2) { return r2 < 1.0 ? std::sqrt(1.0 - r2) : 0.0; };
  double sum = 0.0;
  for (int i = 0; i < kAngles; ++i) {
    const double angle = 2.0 * std::numbers::pi * (i + 0.5) / kAngles, c = std::cos(angle);
    for (int j = 0; j < kSteps; ++j) {
      const double t = (s + 1.0) * (j + 0.5) / kSteps;
      sum += pressure(s * s + t * t + 2.0 * s * t * c) * (s + 1.0) / kSteps;
    }
  }
  return sum * 2.0 * std::numbers::pi / kAngles / (0.5 * std::numbers::pi * std::numbers::pi);
}

TEST(DentShape, HalfSpaceProfileIsBoussinesqsIntegral) {
  for (const double s : {0.0, 0.5, 0.99, 1.2, 1.49, 1.51, 2.0, 4.0})
    EXPECT_NEAR(half_space_profile(s), profile_by_integral(s), 1e-3) << s;
  EXPECT_NEAR(half_space_profile(1.5 - 1e-9), half_space_profile(1.5), 1e-4);
}

// A flat sheet of vertices over one facet, and sites whose rest is `rest` everywhere along -z.
struct FlatDent {
  static constexpr double kTip = 0.005;
  scene::TriangleMesh surface;
  DentShape dent;

  static scene::TriangleMesh sheet() {
    scene::TriangleMesh mesh;
    for (int i = -20; i <= 20; ++i)
      for (int j = -20; j <= 20; ++j) mesh.vertices.push_back({1e-3 * i, 1e-3 * j, 0.0});
    mesh.triangles.push_back({0, 1, 2});
    return mesh;
  }
  static DentShape make(const scene::TriangleMesh& mesh, double rest) {
    std::vector<Anchor> anchors(mesh.vertices.size());
    for (Anchor& anchor : anchors) anchor.nodes = {0, 0, 0, 0, 0, 0}, anchor.shares = {1, 0, 0, 0, 0, 0};
    DentTable table;
    for (int i = -2; i <= 2; ++i)
      for (int j = -2; j <= 2; ++j)
        table.sites.push_back({Vector3(0.007 * i, 0.007 * j, 0.0), {0.0, 0.0, 1.0}});
    table.rest.own.assign(table.sites.size(), rest);
    table.rest.moved = Eigen::MatrixXf::Zero(3, static_cast<Eigen::Index>(table.sites.size()));
    table.rest.moved.row(2).setConstant(static_cast<float>(-rest));
    return DentShape(mesh, anchors, table, kTip);
  }
  explicit FlatDent(double rest) : surface(sheet()), dent(make(surface, rest)) {}
  std::vector<Vector3> press(const Vector3& foot, double depth, double newtons) const {
    std::vector<Vector3> places(surface.vertices.size());
    dent.press(foot + Vector3(0.0, 0.0, kTip - depth), depth, Vector3(0.0, 0.0, newtons), places);
    return places;
  }
};

TEST(DentShape, LiesOnTheTipAndNotInIt) {
  const FlatDent flat(0.004);
  const Vector3 foot(0.002, -0.003, 0.0);
  constexpr double kDepth = 0.003, kNewtons = 0.12;
  const auto places = flat.press(foot, kDepth, kNewtons);
  const Vector3 tip = foot + Vector3(0.0, 0.0, FlatDent::kTip - kDepth);
  double deepest = 0.0;
  for (const Vector3& place : places) {
    EXPECT_GT((place - tip).norm(), FlatDent::kTip - 1e-9);
    deepest = std::min(deepest, place.z());
  }
  EXPECT_NEAR(deepest, -kDepth, 1e-6);
}

TEST(DentShape, FarAwayItIsTheRestAndTheHalfSpace) {
  constexpr double kRest = 0.004, kDepth = 0.003, kNewtons = 0.12;
  const FlatDent flat(kRest);
  const auto places = flat.press(Vector3::Zero(), kDepth, kNewtons);
  const double delta = kDepth - kRest * kNewtons, a = deformable::footprint(FlatDent::kTip, delta);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const double distance = flat.surface.vertices[i].norm();
    if (distance < 2.0 * a) continue;
    EXPECT_NEAR(places[i].z(), -kRest * kNewtons - delta * half_space_profile(distance / a), 1e-8);
  }
}

TEST(DentShape, WithoutForceItIsAtRest) {
  const FlatDent flat(0.004);
  EXPECT_EQ(flat.press(Vector3::Zero(), 0.0, 0.0), flat.surface.vertices);
  EXPECT_EQ(flat.press(Vector3::Zero(), 0.003, std::nan("")), flat.surface.vertices);
}

}  // namespace
}  // namespace palpate::physics::organ
