#include "palpate/system/outside_view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/sim/head_motion.h"
#include "palpate/sim/sim_world.h"

namespace palpate {
namespace {

const CameraModel kHeadLens{640, 480, 560, 561.5, 318.7, 242.1, {-0.28, 0.09, 0.001, -0.0005, 0.0}};

Pixel seen_by(const Eye& eye, const Vector3& p) {
  return eye.camera.project_undistorted((eye.X_world_camera.inverse() * Point<World>{p}).m);
}

bool within(const Eye& eye, const Vector3& p, double margin) {
  const Vector3 q = (eye.X_world_camera.inverse() * Point<World>{p}).m;
  const Pixel at = seen_by(eye, p);
  return q.z() > 0.1 && at.x() > margin && at.y() > margin && at.x() < eye.camera.width - 1 - margin &&
         at.y() < eye.camera.height - 1 - margin;
}

TEST(Onlooker, HasTableWallAndThePlayersHeadInView) {
  const auto file = sim::reference_world();
  for (const auto& [width, height] : {std::pair{640, 480}, std::pair{1280, 720}}) {
    const Eye eye = onlooker(file.scene.table, width, height);
    for (const auto& corners : {file.scene.table, file.scene.wall})
      for (const auto& corner : corners) EXPECT_TRUE(within(eye, corner, 4)) << corner.transpose();
    // The head's own size round its camera.
    for (const double side : {-0.2, 0.2})
      EXPECT_TRUE(within(eye, file.head.eye + Vector3(0, 0, side), 10)) << side;
    // Upright, the player at the right, who looks to the left.
    EXPECT_LT(seen_by(eye, file.head.eye + Vector3(0, 0.1, 0)).y(), seen_by(eye, file.head.eye).y());
    EXPECT_GT(seen_by(eye, file.head.eye).x(), seen_by(eye, file.head.look_at).x());
  }
}

TEST(Onlooker, StandsBesideTheTableWhereverThatStandsAndHoweverLargeItIs) {
  const auto table = sim::reference_world().scene.table;
  const Eye eye = onlooker(table, 640, 480);
  const Pose<World, World> moved{so3_exp(Vector3(0.2, 1.9, -0.4)), {0.3, -2.0, 0.7}};
  std::array<Vector3, 4> there;
  for (std::size_t i = 0; i < 4; ++i) there[i] = 1.7 * (moved * Point<World>{table[i]}).m;
  const Eye other = onlooker(there, 640, 480);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_LT((seen_by(eye, table[i]) - seen_by(other, there[i])).norm(), 1e-9);
}

TEST(Onlooker, LooksAtASceneSTableAndRefusesOneWithoutAnything) {
  const auto file = sim::reference_world();
  const std::vector<SceneSurface> surfaces{{"wall", file.scene.wall}, {"table", file.scene.table}};
  EXPECT_EQ(onlooker(surfaces, 640, 480).X_world_camera.translation,
            onlooker(file.scene.table, 640, 480).X_world_camera.translation);
  EXPECT_THROW(onlooker(std::vector<SceneSurface>{}, 640, 480), std::invalid_argument);
  std::array<Vector3, 4> nothing;
  nothing.fill(Vector3(1.0, 2.0, 3.0));
  EXPECT_THROW(onlooker(nothing, 640, 480), std::invalid_argument);
}

// The base's corners, seen by the player, are the outer corners of the player's picture.
TEST(PlayersCamera, SeesWhatIsInItsPyramid) {
  const auto corners = sight_corners(kHeadLens);
  const std::array<Pixel, 4> expected{{{-0.5, -0.5}, {639.5, -0.5}, {639.5, 479.5}, {-0.5, 479.5}}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT((kHeadLens.project_undistorted(corners[i]) - expected[i]).norm(), 1e-9) << i;
    EXPECT_DOUBLE_EQ(corners[i].z(), PlayersCamera::kSightLength);
  }
}

TEST(PlayersCamera, IsWornOnAHeadOnlyWhereOneWearsIt) {
  EXPECT_EQ(PlayersCamera(kHeadLens, true).items({}).size(), 3u);
  const PlayersCamera on_a_stand(kHeadLens, false);
  for (const auto& item : on_a_stand.items({})) EXPECT_NE(item.material, Material::figure);
}

// The pyramid's edges are yellow where they must appear, and nothing else is; what lies apart from camera and
// pyramid is as it was without.
TEST(PlayersCamera, IsDrawnWhereItsPoseSaysAndNowhereElse) {
  const auto file = sim::reference_world();
  const Eye eye = onlooker(file.scene.table, 640, 480);
  const Pose<World, CameraOptical> X = sim::looking(file.head.eye, file.head.look_at);
  RealScene real;
  real.surfaces = {{"table", file.scene.table}, {"wall", file.scene.wall}};
  const PlayersCamera camera(kHeadLens, true);
  Compositor compositor(CompositorSettings{.shadows = false});
  std::vector<std::uint8_t> with, without;
  compositor.draw({&eye, 1}, {}, real, without);
  compositor.draw({&eye, 1}, camera.items(X), real, with);
  const auto at = [&](int u, int v) { return &with[static_cast<std::size_t>(3 * (640 * v + u))]; };
  const auto yellow = [&](int u, int v) {
    const auto* p = at(u, v);
    return p[0] > 110 && p[1] > 95 && p[0] - p[2] > 45 && std::abs(p[0] - p[1]) < 40;
  };
  const auto corners = sight_corners(kHeadLens);
  std::vector<std::pair<Vector3, Vector3>> edges;
  for (std::size_t i = 0; i < 4; ++i) {
    // From in front of the camera's body.
    edges.emplace_back(0.15 * corners[i], corners[i]);
    edges.emplace_back(corners[i], corners[(i + 1) % 4]);
  }
  std::vector<Pixel> along;
  int missed = 0;
  for (const auto& [a, b] : edges)
    for (double s = 0.0; s <= 1.0; s += 0.02) {
      const Pixel pixel = seen_by(eye, (X * Point<CameraOptical>{a + s * (b - a)}).m);
      along.push_back(pixel);
      const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
      missed +=
          !(yellow(u, v) || yellow(u - 1, v) || yellow(u + 1, v) || yellow(u, v - 1) || yellow(u, v + 1));
    }
  // An edge is 3 px wide, and its lower side dark.
  EXPECT_LT(missed, 0.03 * static_cast<double>(along.size()));
  // The head's ellipsoid and the mark over the base lie within 0.32 m of the camera.
  const Pixel middle = seen_by(eye, X.translation);
  const double reach =
      1.15 * 0.42 / (eye.X_world_camera.inverse() * Point<World>{X.translation}).m.z() * eye.camera.fx;
  int changed = 0, elsewhere = 0;
  for (int v = 0; v < 480; ++v)
    for (int u = 0; u < 640; ++u) {
      const auto i = static_cast<std::size_t>(3 * (640 * v + u));
      const bool same = std::equal(&with[i], &with[i] + 3, &without[i]);
      changed += !same;
      elsewhere += !same && (Pixel(u, v) - middle).norm() > reach;
    }
  EXPECT_EQ(elsewhere, 0);
  EXPECT_GT(changed, 2000);  // a head of some 70 px
}

}  // namespace
}  // namespace palpate
