#include "palpate/desktop/mouse_hand.h"

#include <gtest/gtest.h>

#include <cmath>

namespace palpate::desktop {
namespace {

// A person behind a table: the eye above and behind the bat, looking down and away.
struct MouseSetup {
  device::CameraModel camera;
  MouseHandSettings settings;
  Pose<World, CameraOptical> X_world_camera;
  MouseSetup() {
    settings.home = {0.1, -1.2, 1.7};
    settings.faces = Vector3(0.0, -1.2, 0.8);
    const Vector3 eye(0.0, -0.95, 2.3), z = (Vector3(0.0, -1.45, 1.4) - eye).normalized();
    const Vector3 x = z.cross(Vector3::UnitY()).normalized();
    Matrix3 R;
    R << x, z.cross(x), z;
    X_world_camera = {Quaternion(R), eye};
  }
  device::Pixel pixel_of(const Vector3& p) const {
    return camera.project_undistorted((X_world_camera.inverse() * Point<World>{p}).m);
  }
};

Vector3 bat_of(const device::HandTarget& target, const MouseHandSettings& settings) {
  return target.tip.m + target.R_world_tip * settings.offset;
}

device::HandTarget settle(MouseHand& hand, double from, double to) {
  device::HandTarget target;
  for (double t = from; t <= to; t += 0.004) target = hand.act(t);
  return target;
}

TEST(MouseHand, PutsTheBatUnderThePointer) {
  const MouseSetup setup;
  for (const device::Pixel& pixel :
       {device::Pixel(300, 200), device::Pixel(400, 260), device::Pixel(220, 150)}) {
    MouseHand hand(setup.camera, setup.settings);
    hand.see(setup.X_world_camera);
    hand.point(pixel);
    const device::HandTarget target = settle(hand, 0.0, 2.0);
    // e^-90 of the way is left after 2 s.
    EXPECT_LT((setup.pixel_of(bat_of(target, setup.settings)) - pixel).norm(), 0.01);
    EXPECT_LT(target.velocity.norm(), 1e-3);
  }
}

TEST(MouseHand, KeepsTheBatUnderARestingPointerWhileTheHeadTurns) {
  MouseSetup setup;
  MouseHand hand(setup.camera, setup.settings);
  hand.see(setup.X_world_camera);
  hand.point({330, 220});
  settle(hand, 0.0, 1.0);
  setup.X_world_camera.rotation =
      Quaternion(Eigen::AngleAxisd(0.1, Vector3::UnitY())) * setup.X_world_camera.rotation;
  hand.see(setup.X_world_camera);
  const device::HandTarget target = settle(hand, 1.0, 3.0);
  EXPECT_LT((setup.pixel_of(bat_of(target, setup.settings)) - device::Pixel(330, 220)).norm(), 0.01);
}

TEST(MouseHand, GoesUnderThePointerInThePictureOfAnotherCamera) {
  const MouseSetup setup;
  MouseHand hand(setup.camera, setup.settings);
  hand.see(setup.X_world_camera);
  // Of somebody who stands at the left, with another lens.
  MouseSetup left;
  left.camera.fx = left.camera.fy = 700.0;
  const Vector3 eye(-1.6, -0.8, 2.2), z = (left.settings.home - eye).normalized();
  const Vector3 x = z.cross(Vector3::UnitY()).normalized();
  Matrix3 R;
  R << x, z.cross(x), z;
  left.X_world_camera = {Quaternion(R), eye};
  hand.look_through(left.camera);
  hand.see(left.X_world_camera);
  const device::Pixel pixel(350, 220);
  hand.point(pixel);
  const device::HandTarget target = settle(hand, 0.0, 2.0);
  EXPECT_LT((left.pixel_of(bat_of(target, left.settings)) - pixel).norm(), 0.01);
}

TEST(MouseHand, PushesTheBatForwardAndUpWithThePointer) {
  const MouseSetup setup;
  MouseHand hand(setup.camera, setup.settings);
  hand.see(setup.X_world_camera);
  hand.point({330, 260});
  const Vector3 low = hand.wanted();
  hand.point({330, 200});
  const Vector3 high = hand.wanted();
  EXPECT_GT(high.y() - low.y(), 0.02);
  EXPECT_LT(high.z() - low.z(), -0.01);
  // On the plane that leans by 0.6 rad.
  EXPECT_NEAR((low.z() - high.z()) / (high.y() - low.y()), std::tan(0.6), 1e-9);
}

TEST(MouseHand, LetsTheWheelMoveTheBatAwayAndBackUpToItsEnds) {
  const MouseSetup setup;
  MouseHand hand(setup.camera, setup.settings);
  EXPECT_DOUBLE_EQ(hand.wanted().z(), 1.7);
  hand.roll(2.0);
  EXPECT_DOUBLE_EQ(hand.wanted().z(), 1.67);
  hand.roll(-4.0);
  EXPECT_DOUBLE_EQ(hand.wanted().z(), 1.73);
  hand.roll(-1000.0);
  EXPECT_DOUBLE_EQ(hand.wanted().z(), 1.8);
  hand.roll(1.0);  // the wheel's way beyond the end was not stored up
  EXPECT_DOUBLE_EQ(hand.wanted().z(), 1.785);
}

TEST(MouseHand, FacesTheMiddleOfTheWallAndLooksUpALittle) {
  const MouseSetup setup;
  MouseHand hand(setup.camera, setup.settings);
  const device::HandTarget target = settle(hand, 0.0, 0.1);
  const Vector3 normal = target.R_world_tip * Vector3::UnitY();
  const Vector3 way = *setup.settings.faces - setup.settings.home;
  EXPECT_NEAR(normal.x() / normal.z(), way.x() / way.z(), 1e-9);
  EXPECT_NEAR(normal.y() / std::hypot(normal.x(), normal.z()), 0.25, 1e-9);
}

TEST(MouseHand, TurnsTheBatWhileAButtonIsHeld) {
  const MouseSetup setup;
  MouseHand hand(setup.camera, setup.settings);
  const auto yaw = [](const device::HandTarget& target) {
    const Vector3 normal = target.R_world_tip * Vector3::UnitY();
    return std::atan2(-normal.x(), -normal.z());
  };
  const double straight = yaw(settle(hand, 0.0, 0.1));
  hand.hold_buttons(true, false);
  EXPECT_NEAR(yaw(settle(hand, 0.1, 2.0)) - straight, 0.45, 1e-6);  // to the left
  hand.hold_buttons(false, true);
  EXPECT_NEAR(yaw(settle(hand, 2.0, 4.0)) - straight, -0.45, 1e-6);
  hand.hold_buttons(false, false);
  EXPECT_NEAR(yaw(settle(hand, 4.0, 6.0)), straight, 1e-6);
}

// Differences of positions a millisecond apart: what a hand would have to do.
TEST(MouseHand, MovesNoFasterThanAHandHoweverTheMouseJumps) {
  const MouseSetup setup;
  MouseHand hand(setup.camera, setup.settings);
  hand.see(setup.X_world_camera);
  Vector3 before = bat_of(hand.act(0.0), setup.settings), velocity_before = Vector3::Zero();
  double fastest = 0.0, hardest = 0.0;
  for (int ms = 1; ms < 3000; ++ms) {
    if (ms % 170 == 1) hand.point(ms % 340 == 1 ? device::Pixel(-5000, 100) : device::Pixel(5000, 300));
    const Vector3 now = bat_of(hand.act(ms * 1e-3), setup.settings);
    const Vector3 velocity = (now - before) / 1e-3;
    fastest = std::max(fastest, velocity.norm());
    hardest = std::max(hardest, (velocity - velocity_before).norm() / 1e-3);
    before = now;
    velocity_before = velocity;
  }
  // As fast as a hand, and no faster, to the rounding of the differences.
  EXPECT_LE(fastest, setup.settings.max_speed * (1.0 + 1e-6));
  EXPECT_GT(fastest, 0.9 * setup.settings.max_speed);
  EXPECT_LE(hardest, setup.settings.max_acceleration * (1.0 + 1e-6));
  EXPECT_GT(hardest, 0.9 * setup.settings.max_acceleration);
}

TEST(MouseHand, StopsWhereThePointerIsWithoutGoingPastIt) {
  const MouseSetup setup;
  MouseHand hand(setup.camera, setup.settings);
  hand.see(setup.X_world_camera);
  hand.point({600, 220});
  const Vector3 goal = hand.wanted(), start = setup.settings.home, way = (goal - start).normalized();
  hand.act(0.0);
  double farthest = 0.0;
  for (int ms = 1; ms < 2000; ++ms)
    farthest = std::max(farthest, way.dot(bat_of(hand.act(ms * 1e-3), setup.settings) - start));
  EXPECT_LT(farthest, (goal - start).norm() + 0.01);
}

TEST(MouseHand, StaysWithinTheArmsReach) {
  MouseSetup setup;
  const Vector3 middle = setup.settings.home - Vector3(0.0, 0.1, 0.0);
  setup.settings.reachable = [middle](const Vector3& tip) { return (tip - middle).norm() < 0.15; };
  MouseHand hand(setup.camera, setup.settings);
  hand.see(setup.X_world_camera);
  for (const device::Pixel& pixel : {device::Pixel(0, 0), device::Pixel(639, 0), device::Pixel(0, 479),
                                     device::Pixel(1e6, -1e6), device::Pixel(320, 240)}) {
    hand.point(pixel);
    for (const double notches : {0.0, 10.0, -20.0, 10.0}) {
      hand.roll(notches);
      const Vector3 bat = hand.wanted();
      MouseHandSettings at_bat = setup.settings;  // whose stylus is turned as this bat's is
      at_bat.home = bat;
      MouseHand there(setup.camera, at_bat);
      EXPECT_TRUE(setup.settings.reachable(there.act(0.0).tip.m)) << pixel.transpose() << ' ' << notches;
    }
  }
}

TEST(MouseHand, GoesToHomeWhileNothingIsPointedAtOrSeen) {
  const MouseSetup setup;
  MouseHand blind(setup.camera, setup.settings);
  blind.point({100, 100});  // no picture yet
  EXPECT_EQ(blind.wanted(), setup.settings.home);
  MouseHand idle(setup.camera, setup.settings);
  idle.see(setup.X_world_camera);
  EXPECT_EQ(idle.wanted(), setup.settings.home);
}

TEST(MouseHand, GoesOnFromWhereSomebodyElseLeftTheHand) {
  const MouseSetup setup;
  MouseHand hand(setup.camera, setup.settings);
  device::HandTarget left;
  left.tip.m = setup.settings.home + Vector3(0.1, 0.05, 0.0);
  hand.take_over(left, 5.0);
  const device::HandTarget next = hand.act(5.001);
  EXPECT_LT((bat_of(next, setup.settings) - bat_of(left, setup.settings)).norm(), 0.003);
}

TEST(MouseHand, GoesOnFromAnotherTurnWithoutAJump) {
  const MouseSetup setup;
  MouseHand hand(setup.camera, setup.settings);
  device::HandTarget at = hand.act(0.0);
  at.R_world_tip = so3_exp(Vector3(0.5, -0.3, 0.2)) * at.R_world_tip;
  hand.take_over(at, 0.0);
  device::HandTarget before = hand.act(0.0);
  EXPECT_LT(angle_between(before.R_world_tip, at.R_world_tip), 1e-9);
  EXPECT_LT((before.tip.m - at.tip.m).norm(), 1e-12);
  double fastest = 0.0;
  for (int ms = 1; ms < 1000; ++ms) {
    const device::HandTarget now = hand.act(ms * 1e-3);
    fastest = std::max(fastest, (now.tip.m - before.tip.m).norm() / 1e-3);
    before = now;
  }
  // 0.62 rad at 12 1/s over the bat's 90 mm: 0.7 m/s, and what its way back takes. At once it would be 50
  // m/s.
  EXPECT_LT(fastest, 2.0);
  EXPECT_LT(angle_between(before.R_world_tip, MouseHand(setup.camera, setup.settings).act(0.0).R_world_tip),
            1e-3);
}

TEST(MouseHand, HoldsAStylusUprightWhereThereIsNoBat) {
  MouseSetup setup;
  setup.settings.faces.reset();
  setup.settings.offset.setZero();
  MouseHand hand(setup.camera, setup.settings);
  const device::HandTarget target = settle(hand, 0.0, 0.1);
  EXPECT_LT((target.R_world_tip * Vector3::UnitZ() - setup.settings.up).norm(), 1e-12);
  EXPECT_NEAR(Matrix3(target.R_world_tip).determinant(), 1.0, 1e-12);
}

}  // namespace
}  // namespace palpate::desktop
