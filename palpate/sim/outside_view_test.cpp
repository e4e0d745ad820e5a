#include "palpate/render/outside_view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "palpate/math/looking.h"
#include "palpate/render/picture_looks.h"
#include "palpate/sim/head_motion.h"
#include "palpate/sim/simulator.h"

namespace palpate::sim {
namespace {

constexpr scene::Look kOrange{{0.86f, 0.30f, 0.035f}, 0.010f, 0.10f, 0.10f};
const device::CameraModel kHeadLens{640, 480, 560, 561.5, 318.7, 242.1, {-0.28, 0.09, 0.001, -0.0005, 0.0}};

device::Pixel seen_by(const render::Viewpoint& eye, const Vector3& p) {
  return eye.camera.project_undistorted((eye.X_world_camera.inverse() * Point<World>{p}).m);
}

bool within(const render::Viewpoint& eye, const Vector3& p, double margin) {
  const Vector3 q = (eye.X_world_camera.inverse() * Point<World>{p}).m;
  const device::Pixel at = seen_by(eye, p);
  return q.z() > 0.1 && at.x() > margin && at.y() > margin && at.x() < eye.camera.width - 1 - margin &&
         at.y() < eye.camera.height - 1 - margin;
}

TEST(Onlooker, HasTableWallAndThePlayersHeadInView) {
  const auto file = config::reference_world();
  for (const auto& [width, height] : {std::pair{640, 480}, std::pair{1280, 720}}) {
    const render::Viewpoint eye = render::onlooker(file.scene.table, width, height);
    for (const auto& corners : {file.scene.table, file.scene.wall})
      for (const auto& corner : corners) EXPECT_TRUE(within(eye, corner, 4)) << corner.transpose();
    // The head's own size round its camera.
    for (const double side : {-0.2, 0.2})
      EXPECT_TRUE(within(eye, file.head.eye + Vector3(0, 0, side), 10)) << side;
    // The feet of the table's legs, too.
    const Vector3 down(0, -render::Furniture::kTableHeight, 0);
    for (const auto& corner : file.scene.table)
      EXPECT_TRUE(within(eye, corner + down, 4)) << corner.transpose();
    // Upright, the player at the right, who looks to the left.
    EXPECT_LT(seen_by(eye, file.head.eye + Vector3(0, 0.1, 0)).y(), seen_by(eye, file.head.eye).y());
    EXPECT_GT(seen_by(eye, file.head.eye).x(), seen_by(eye, file.head.look_at).x());
  }
}

TEST(Onlooker, StandsBesideTheTableWhereverThatStandsAndHoweverLargeItIs) {
  const auto table = config::reference_world().scene.table;
  const render::Viewpoint eye = render::onlooker(table, 640, 480);
  const Pose<World, World> moved{so3_exp(Vector3(0.2, 1.9, -0.4)), {0.3, -2.0, 0.7}};
  std::array<Vector3, 4> there;
  for (std::size_t i = 0; i < 4; ++i) there[i] = 1.7 * (moved * Point<World>{table[i]}).m;
  const render::Viewpoint other = render::onlooker(there, 640, 480);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_LT((seen_by(eye, table[i]) - seen_by(other, there[i])).norm(), 1e-9);
}

TEST(Onlooker, WalksRoundThePlayAndComesNearerLookingAtItsMiddle) {
  const std::vector<scene::SceneSurface> surfaces{{"table", config::reference_world().scene.table}};
  const render::Viewpoint home = render::onlooker(surfaces, 640, 480);
  render::Onlooker walking(surfaces, 640, 480);
  const auto stands = [&] { return walking.viewpoint().X_world_camera.translation; };
  EXPECT_EQ(stands(), home.X_world_camera.translation);
  walking.walk(0.0, 0.0);
  EXPECT_LT((stands() - home.X_world_camera.translation).norm(), 1e-12) << "nobody has walked";
  // Where home looks, at the height of the table.
  const Vector3 ahead = home.X_world_camera.rotation * Vector3::UnitZ();
  const double top = surfaces[0].corners[0].y();
  const Vector3 middle =
      home.X_world_camera.translation + (top - home.X_world_camera.translation.y()) / ahead.y() * ahead;
  const double way = (home.X_world_camera.translation - middle).norm();
  walking.walk(0.7, 0.3);
  EXPECT_NEAR((stands() - middle).norm(), way, 1e-9);
  EXPECT_LT((seen_by(walking.viewpoint(), middle) - seen_by(home, middle)).norm(), 1e-6);
  const Vector3 moved =
      home.X_world_camera.rotation.conjugate() * (stands() - home.X_world_camera.translation);
  EXPECT_GT(moved.x(), 0.5) << "to their right";
  EXPECT_LT(moved.y(), -0.2) << "and up";
  walking.approach(3.0);
  EXPECT_NEAR((stands() - middle).norm(), way * std::pow(0.9, 3), 1e-9);
  walking.walk(-0.7, -0.3);
  walking.approach(-3.0);
  EXPECT_LT((stands() - home.X_world_camera.translation).norm(), 1e-9) << "and back";
  walking.walk(0.0, 9.0);
  EXPECT_GT(stands().y() - top, 0.99 * way) << "nearly above";
  EXPECT_TRUE(walking.viewpoint().X_world_camera.rotation.coeffs().allFinite());
  walking.walk(0.0, -9.0);
  EXPECT_GT(stands().y(), top) << "not below the table";
  walking.approach(100.0);
  EXPECT_GT((stands() - middle).norm(), 0.2);
  walking.approach(-100.0);
  EXPECT_LT((stands() - middle).norm(), 2.0 * way);
}

TEST(Onlooker, LooksAtASceneSTableAndRefusesOneWithoutAnything) {
  const auto file = config::reference_world();
  const std::vector<scene::SceneSurface> surfaces{{"wall", file.scene.wall}, {"table", file.scene.table}};
  EXPECT_EQ(render::onlooker(surfaces, 640, 480).X_world_camera.translation,
            render::onlooker(file.scene.table, 640, 480).X_world_camera.translation);
  EXPECT_THROW(render::onlooker(std::vector<scene::SceneSurface>{}, 640, 480), std::invalid_argument);
  std::array<Vector3, 4> nothing;
  nothing.fill(Vector3(1.0, 2.0, 3.0));
  EXPECT_THROW(render::onlooker(nothing, 640, 480), std::invalid_argument);
}

// The base's corners, seen by the player, are the outer corners of the player's picture.
TEST(PlayersCamera, SeesWhatIsInItsPyramid) {
  const auto corners = render::sight_corners(kHeadLens);
  const std::array<device::Pixel, 4> expected{{{-0.5, -0.5}, {639.5, -0.5}, {639.5, 479.5}, {-0.5, 479.5}}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT((kHeadLens.project_undistorted(corners[i]) - expected[i]).norm(), 1e-9) << i;
    EXPECT_DOUBLE_EQ(corners[i].z(), render::PlayersCamera::kSightLength);
  }
}

TEST(PlayersCamera, IsWornOnAHeadOnlyWhereOneWearsIt) {
  EXPECT_EQ(render::PlayersCamera(kHeadLens, true).items({}).size(), 3u);
  const render::PlayersCamera on_a_stand(kHeadLens, false);
  for (const auto& item : on_a_stand.items({})) EXPECT_NE(item.look, render::kFigureLook);
}

// Two cameras of one make, 64 mm apart: the right one is the left one moved, the head sits between them.
TEST(PlayersCamera, OfTwoEyesHasTwoBodiesAndTwoPyramidsOnOneHead) {
  const double apart = 0.064;
  const render::PlayersCamera pair(kHeadLens, kHeadLens,
                                   {so3_exp(Vector3(0.0, -0.02, 0.0)), Vector3(apart, 0.0, 0.0)});
  const Pose<World, CameraOptical> anywhere{so3_exp(Vector3(0.3, 1.0, 0.2)), {0.2, -1.0, 2.1}};
  const auto items = pair.items(anywhere);
  ASSERT_EQ(items.size(), 4u);
  for (const auto& item : items) EXPECT_EQ(item.position, anywhere.translation);
  const auto extent = [](const scene::TriangleMesh& mesh) {
    Eigen::AlignedBox3d box;
    for (const auto& v : mesh.vertices) box.extend(v);
    return box;
  };
  const auto of = [&](const scene::Look& look) {
    std::vector<const scene::TriangleMesh*> meshes;
    for (const auto& item : items)
      if (item.look == look) meshes.push_back(item.mesh);
    return meshes;
  };
  ASSERT_EQ(of(render::kFigureLook).size(), 1u);
  ASSERT_EQ(of(render::kCameraLook).size(), 1u);
  ASSERT_EQ(of(render::kSightLook).size(), 2u);
  EXPECT_NEAR(extent(*of(render::kFigureLook)[0]).center().x(), 0.5 * apart, 1e-9);
  // A body round each lens, none in the middle between them, where the band alone passes behind.
  int left = 0, right = 0, between = 0;
  for (const auto& v : of(render::kCameraLook)[0]->vertices) {
    if (v.z() < -0.065) continue;
    left += std::abs(v.x()) < 0.031;
    right += std::abs(v.x() - apart) < 0.033;
    between += std::abs(v.x() - 0.5 * apart) < 0.001 && v.z() > -0.06;
  }
  EXPECT_GT(left, 40);
  EXPECT_GT(right, 40);
  EXPECT_EQ(between, 0);
  // The right pyramid is the left one, turned and moved as its camera is.
  const auto &first = of(render::kSightLook)[0]->vertices, &second = of(render::kSightLook)[1]->vertices;
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); i += 7)
    EXPECT_LT((so3_exp(Vector3(0.0, -0.02, 0.0)) * first[i] + Vector3(apart, 0.0, 0.0) - second[i]).norm(),
              1e-12);
  // A right camera that is silent is worn all the same, and sees nothing.
  EXPECT_EQ(pair.items(anywhere, false).size(), 3u);
}

TEST(Furniture, StandsOnTheFloorUnderTheTableWhereverThatIs) {
  const Vector3 lamp(0.45, 0.55, 1.95);
  const auto table = config::reference_world().scene.table;
  for (const double turn : {0.0, 0.8}) {
    const Pose<World, World> moved{so3_exp(Vector3(0.0, turn, 0.0)), {0.3, 0.2, 0.0}};
    std::array<Vector3, 4> there;
    for (std::size_t i = 0; i < 4; ++i) there[i] = (moved * Point<World>{table[i]}).m;
    const render::Furniture furniture(there, lamp);
    const auto items = furniture.items();
    ASSERT_EQ(items.size(), 3u);
    const double top = there[0].y(), ground = top - render::Furniture::kTableHeight;
    for (const auto& v : items[0].mesh->vertices) EXPECT_NEAR(v.y(), ground, 1e-9);
    // Each ray from the lamp by a corner of the table ends at a corner of the shade.
    for (const auto& corner : there) {
      const Vector3 end = lamp + (ground + 0.001 - lamp.y()) / (corner.y() - lamp.y()) * (corner - lamp);
      double nearest = 1.0;
      for (const auto& v : items[1].mesh->vertices) nearest = std::min(nearest, (v - end).norm());
      EXPECT_LT(nearest, 1e-9);
    }
    // Legs and board stay under the table, and legs reach the floor near each corner.
    const Vector3 side = (there[1] - there[0]).normalized(), back = (there[3] - there[0]).normalized();
    std::array<int, 4> feet{};
    for (const auto& v : items[2].mesh->vertices) {
      const double a = side.dot(v - there[0]), b = back.dot(v - there[0]);
      EXPECT_GT(a, -1e-9);
      EXPECT_LT(a, (there[1] - there[0]).norm() + 1e-9);
      EXPECT_GT(b, -1e-9);
      EXPECT_LT(b, (there[3] - there[0]).norm() + 1e-9);
      EXPECT_LT(v.y(), top);
      EXPECT_GE(v.y(), ground - 1e-9);
      for (std::size_t i = 0; i < 4; ++i)
        feet[i] += v.y() < ground + 1e-9 && std::hypot(v.x() - there[i].x(), v.z() - there[i].z()) < 0.12;
    }
    for (const int foot : feet) EXPECT_GT(foot, 8);
    for (const auto& item : items) EXPECT_FALSE(item.casts_shadow);
  }
}

// What only looks on sees it; the picture over a camera's image is the same to the bit.
TEST(Furniture, IsSeenFromOutsideAndNeverInTheCamerasPicture) {
  const auto file = config::reference_world();
  render::RealScene bare;
  bare.surfaces = {{"table", file.scene.table}, {"wall", file.scene.wall}};
  render::RealScene furnished = bare;
  const render::CompositorSettings settings{};
  const render::Furniture furniture(file.scene.table, settings.light.lamp);
  furnished.backdrop = furniture.items();
  render::Compositor compositor(settings);
  const scene::TriangleMesh ball = scene::sphere_mesh(0.02);
  const std::vector<scene::DrawItem> items{
      {&ball, kOrange, Quaternion::Identity(), file.scene.table[0] + Vector3(0.3, 0.1, -0.4), true}};
  std::vector<std::uint8_t> with, without;
  const render::Viewpoint eye = render::onlooker(file.scene.table, 640, 480);
  compositor.draw({&eye, 1}, items, bare, without);
  compositor.draw({&eye, 1}, items, furnished, with);
  const auto at = [](const std::vector<std::uint8_t>& rgb, const device::Pixel& p) {
    const auto i = static_cast<std::size_t>(3 * (640 * std::lround(p.y()) + std::lround(p.x())));
    return Vector3(rgb[i], rgb[i + 1], rgb[i + 2]);
  };
  const Vector3 side = (file.scene.table[1] - file.scene.table[0]).normalized(),
                back = (file.scene.table[3] - file.scene.table[0]).normalized(),
                nearest = file.scene.table[0];
  const Vector3 air = at(without, {4.0, 4.0});
  // Half way down the near left leg: dark. Beside it the floor. Neither was there before.
  const Vector3 leg = nearest + 0.045 * side + 0.06 * back - Vector3(0, 0.4, 0);
  const Vector3 floor = nearest + 1.0 * side + 0.3 * back - Vector3(0, render::Furniture::kTableHeight, 0);
  EXPECT_EQ(at(without, seen_by(eye, leg)), air);
  EXPECT_EQ(at(without, seen_by(eye, floor)), air);
  EXPECT_LT(at(with, seen_by(eye, leg)).maxCoeff(), 0.7 * air.minCoeff());
  EXPECT_GT(at(with, seen_by(eye, floor)).x(), at(with, seen_by(eye, floor)).z() + 10.0);  // wood is no grey
  // On the table nothing changes, nor over a camera's image.
  const device::Pixel table = seen_by(eye, nearest + 0.2 * side + 0.5 * back);
  EXPECT_EQ(at(with, table), at(without, table));
  device::CameraImage image;
  image.width = 640, image.height = 480;
  for (int i = 0; i < 640 * 480 * 3; ++i) image.rgb.push_back(static_cast<std::uint8_t>(i % 251));
  const auto X = looking(file.head.eye, file.head.look_at);
  compositor.draw(image, kHeadLens, X, items, bare, without);
  compositor.draw(image, kHeadLens, X, items, furnished, with);
  EXPECT_EQ(with, without);
}

// The pyramid's edges are yellow where they must appear, and nothing else is; what lies apart from camera and
// pyramid is as it was without.
TEST(PlayersCamera, IsDrawnWhereItsPoseSaysAndNowhereElse) {
  const auto file = config::reference_world();
  const render::Viewpoint eye = render::onlooker(file.scene.table, 640, 480);
  const Pose<World, CameraOptical> X = looking(file.head.eye, file.head.look_at);
  render::RealScene real;
  real.surfaces = {{"table", file.scene.table}, {"wall", file.scene.wall}};
  const render::PlayersCamera camera(kHeadLens, true);
  render::Compositor compositor(render::CompositorSettings{.shadows = false});
  std::vector<std::uint8_t> with, without;
  compositor.draw({&eye, 1}, {}, real, without);
  compositor.draw({&eye, 1}, camera.items(X), real, with);
  const auto at = [&](int u, int v) { return &with[static_cast<std::size_t>(3 * (640 * v + u))]; };
  const auto yellow = [&](int u, int v) {
    const auto* p = at(u, v);
    return p[0] > 110 && p[1] > 95 && p[0] - p[2] > 45 && std::abs(p[0] - p[1]) < 40;
  };
  const auto corners = render::sight_corners(kHeadLens);
  std::vector<std::pair<Vector3, Vector3>> edges;
  for (std::size_t i = 0; i < 4; ++i) {
    // From in front of the camera's body.
    edges.emplace_back(0.15 * corners[i], corners[i]);
    edges.emplace_back(corners[i], corners[(i + 1) % 4]);
  }
  std::vector<device::Pixel> along;
  int missed = 0;
  for (const auto& [a, b] : edges)
    for (double s = 0.0; s <= 1.0; s += 0.02) {
      const device::Pixel pixel = seen_by(eye, (X * Point<CameraOptical>{a + s * (b - a)}).m);
      along.push_back(pixel);
      const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
      missed +=
          !(yellow(u, v) || yellow(u - 1, v) || yellow(u + 1, v) || yellow(u, v - 1) || yellow(u, v + 1));
    }
  // An edge is 3 px wide, and its lower side dark.
  EXPECT_LT(missed, 0.03 * static_cast<double>(along.size()));
  // The head's ellipsoid and the mark over the base lie within 0.32 m of the camera.
  const device::Pixel middle = seen_by(eye, X.translation);
  const double reach =
      1.15 * 0.42 / (eye.X_world_camera.inverse() * Point<World>{X.translation}).m.z() * eye.camera.fx;
  int changed = 0, elsewhere = 0;
  for (int v = 0; v < 480; ++v)
    for (int u = 0; u < 640; ++u) {
      const auto i = static_cast<std::size_t>(3 * (640 * v + u));
      const bool same = std::equal(&with[i], &with[i] + 3, &without[i]);
      changed += !same;
      elsewhere += !same && (device::Pixel(u, v) - middle).norm() > reach;
    }
  EXPECT_EQ(elsewhere, 0);
  EXPECT_GT(changed, 2000);  // a head of some 70 px
}

}  // namespace
}  // namespace palpate::sim
