// The mouse as the hand that holds a stylus which touches: MouseHand without a surface that it faces.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/desktop/mouse_hand.h"
#include "palpate/math/looking.h"
#include "palpate/scene/mesh_normals.h"

namespace palpate::desktop {
namespace {

constexpr double kDomeRadius_m = 0.060, kTipRadius_m = 0.006, kPressed_m = 0.005;

// A ball on a table, and somebody who looks down at it from a desk's distance.
struct TouchingSetup {
  device::CameraModel camera;
  MouseHandSettings settings;
  Vector3 middle{0.0, -1.46, 1.6}, eye{0.0, -0.95, 2.15};
  Pose<World, CameraOptical> X_world_camera = looking(eye, middle);
  explicit TouchingSetup(bool explores) {
    settings.home = middle + Vector3(0.0, 0.15, 0.0);
    settings.offset.setZero();
    settings.lean = 0.5 * 3.14159265358979;
    settings.wheel = settings.up;
    settings.stylus_lean = 0.67;
    if (!explores) return;
    scene::ExploredSurface ball;
    ball.mesh = scene::moved(scene::sphere_mesh(kDomeRadius_m, 48, 96), Quaternion::Identity(), middle);
    ball.tip_radius = kTipRadius_m;
    ball.press = kPressed_m;
    settings.surface = std::make_shared<PointedSurface>(std::move(ball), settings.up);
  }
  device::Pixel pixel_of(const Vector3& p) const {
    return camera.project_undistorted((X_world_camera.inverse() * Point<World>{p}).m);
  }
  // Of the ball, towards the eye.
  Vector3 place(double right, double up) const {
    return middle + kDomeRadius_m * Vector3(right, up, std::sqrt(1.0 - right * right - up * up));
  }
};

device::HandTarget held_until(MouseHand& hand, double from, double to) {
  device::HandTarget target;
  for (double t = from; t <= to; t += 0.001) target = hand.act(t);
  return target;
}

TEST(StandingStylus, IsHeldStillByARestingPointerWhileTheHeadTurns) {
  for (const bool explores : {false, true}) {
    TouchingSetup setup(explores);
    MouseHand hand(setup.camera, setup.settings);
    hand.see(setup.X_world_camera);
    const device::Pixel pointer = setup.pixel_of(setup.place(0.2, 0.6));
    hand.point(pointer);
    const Vector3 before = held_until(hand, 0.0, 2.0).tip.m;
    // Ten degrees to and fro, as a head sways.
    double farthest = 0.0;
    for (int i = 0; i < 2000; ++i) {
      Pose<World, CameraOptical> turned = setup.X_world_camera;
      turned.rotation =
          Quaternion(Eigen::AngleAxisd(0.17 * std::sin(0.005 * i), Vector3::UnitY())) * turned.rotation;
      hand.see(turned);
      hand.point(pointer);
      farthest = std::max(farthest, (hand.act(2.0 + 1e-3 * i).tip.m - before).norm());
    }
    EXPECT_LT(farthest, 1e-5) << explores;
  }
}

TEST(StandingStylus, GoesByAsMuchAsThePointerMovesThoughTheHeadHasTurned) {
  TouchingSetup setup(false);
  MouseHand hand(setup.camera, setup.settings);
  hand.see(setup.X_world_camera);
  hand.point({320, 240});
  const Vector3 before = hand.wanted();
  setup.X_world_camera.rotation =
      Quaternion(Eigen::AngleAxisd(0.15, Vector3::UnitY())) * setup.X_world_camera.rotation;
  hand.see(setup.X_world_camera);
  hand.point({324, 240});
  const double moved = (setup.pixel_of(hand.wanted()) - setup.pixel_of(before)).norm();
  EXPECT_GT(moved, 2.5);
  EXPECT_LT(moved, 4.0 * 1.31);
  // Who goes on moving finds it under the pointer again.
  for (int i = 0; i < 200; ++i) hand.point({320.0 + 40.0 * std::sin(0.3 * i), 240});
  hand.point({320, 240});
  EXPECT_LT((setup.pixel_of(hand.wanted()) - device::Pixel(320, 240)).norm(), 3.0);
}

TEST(StandingStylus, LeansTowardsThePerson) {
  TouchingSetup setup(true);
  MouseHand hand(setup.camera, setup.settings);
  const Vector3 shaft = hand.act(0.0).R_world_tip * Vector3::UnitZ();
  EXPECT_NEAR(std::acos(shaft.dot(setup.settings.up)), 0.67, 1e-12);
  EXPECT_LT(shaft.dot(setup.settings.forward), -0.5);
}

TEST(StandingStylus, HoversOverThePlaceUnderThePointerAndPressesItWithTheButton) {
  const TouchingSetup setup(true);
  for (const auto& [right, up] : {std::pair{0.0, 0.9}, std::pair{0.5, 0.5}, std::pair{-0.6, 0.2}}) {
    MouseHand hand(setup.camera, setup.settings);
    hand.see(setup.X_world_camera);
    const Vector3 place = setup.place(right, up), normal = (place - setup.middle).normalized();
    hand.point(setup.pixel_of(place));
    // A polyhedron: 96 corners round a ball of 60 mm lie within 0.04 mm of it.
    const auto depth = [&](double from, double to) {
      return kDomeRadius_m + kTipRadius_m - (held_until(hand, from, to).tip.m - setup.middle).norm();
    };
    EXPECT_NEAR(depth(0.0, 2.0), -0.010, 2e-4);
    hand.hold_buttons(true, false);
    EXPECT_NEAR(depth(2.0, 3.0), kPressed_m, 2e-4);
    const Vector3 tip = hand.act(3.0).tip.m - setup.middle;
    EXPECT_LT(std::acos(std::min(1.0, tip.normalized().dot(normal))), 0.02);
    hand.hold_buttons(false, true);
    EXPECT_LT(depth(3.0, 4.0), -0.05) << "lifted off";
    hand.hold_buttons(false, false);
    hand.roll(-12.0);  // towards the person: down, as it is called
    EXPECT_NEAR(depth(4.0, 6.0), 0.002, 2e-4);
    hand.roll(8.0);
    EXPECT_NEAR(depth(6.0, 7.0), -0.006, 2e-4);
  }
}

TEST(StandingStylus, GoesOverWhatLiesBetweenTwoPlaces) {
  const TouchingSetup setup(true);
  MouseHand hand(setup.camera, setup.settings);
  hand.see(setup.X_world_camera);
  hand.point(setup.pixel_of(setup.place(-0.9, 0.2)));
  held_until(hand, 0.0, 2.0);
  hand.point(setup.pixel_of(setup.place(0.9, 0.2)));
  double lowest = 1.0;
  for (int i = 0; i < 1500; ++i)
    lowest = std::min(lowest,
                      (hand.act(2.0 + 1e-3 * i).tip.m - setup.middle).norm() - kDomeRadius_m - kTipRadius_m);
  EXPECT_GT(lowest, 0.0) << "it went through the ball";
}

TEST(StandingStylus, PressesNoFasterThanTissueIsFelt) {
  const TouchingSetup setup(true);
  MouseHand hand(setup.camera, setup.settings);
  hand.see(setup.X_world_camera);
  hand.point(setup.pixel_of(setup.place(0.0, 0.7)));
  held_until(hand, 0.0, 2.0);
  hand.hold_buttons(true, false);
  double fastest = 0.0;
  for (int i = 0; i < 600; ++i) fastest = std::max(fastest, hand.act(2.0 + 1e-3 * i).velocity.norm());
  EXPECT_LT(fastest, 0.065);
  EXPECT_GT(fastest, 0.045);
}

TEST(PointedSurface, IsThePlaneBelowBesideTheSurface) {
  const TouchingSetup setup(true);
  const Vector3 aside = setup.middle + Vector3(0.2, -kDomeRadius_m, 0.0);
  const auto place = setup.settings.surface->under(setup.eye, (aside - setup.eye).normalized());
  ASSERT_TRUE(place);
  EXPECT_FALSE(place->on_surface);
  EXPECT_LT((place->at - aside).norm(), 1e-4);
  EXPECT_EQ(place->normal, setup.settings.up);
  EXPECT_FALSE(setup.settings.surface->under(setup.eye, Vector3::UnitY()));
  EXPECT_THROW(PointedSurface({}, Vector3::UnitY()), std::invalid_argument);
}

}  // namespace
}  // namespace palpate::desktop
