#include "palpate/desktop/session_shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "palpate/desktop/session_colours.h"

namespace palpate::desktop {
namespace {

using device::Gesture;

constexpr int kWide = 640, kHigh = 480;

// A camera 1 m in front of the origin that looks along -z, its marker 5 cm above it; no lens but for what is set.
SessionView a_calibrated_view() {
  rig::Rig rig;
  rig.camera.emplace();
  rig.camera->model.fx = rig.camera->model.fy = 500.0;
  rig.camera->model.cx = 319.5;
  rig.camera->model.cy = 239.5;
  rig.hand_eye.emplace();
  // Optical frame: x right, y down, z forward; the marker's axes are the world's here.
  rig.hand_eye->X_marker_camera.rotation = Quaternion(0.0, 1.0, 0.0, 0.0);  // half a turn about x
  rig.hand_eye->X_marker_camera.translation = {0.0, -0.05, 0.0};
  rig.tip_pivot.emplace();
  rig.tip_pivot->tip_in_marker = {0.0, 0.0, -0.1};
  auto picture = std::make_shared<SessionPicture>();
  picture->image.width = kWide;
  picture->image.height = kHigh;
  picture->image.rgb.assign(3u * kWide * kHigh, 90);
  picture->marker.seen = true;
  picture->marker.translation = {0.0, 0.05, 1.0};
  SessionView view;
  view.step = 4;
  view.steps = 8;
  view.step_name = "arm";
  view.rig = std::make_shared<rig::Rig>(rig);
  view.picture = picture;
  view.person.head = picture->marker;
  return view;
}

device::Request pose_request(const Vector3& tip) {
  device::Request request{Gesture::next_pose, "", 0};
  request.target = device::PoseTarget{{tip}, Quaternion::Identity(), {0.0, 0.0, -0.1}};
  return request;
}

RodShape rod_from(const Vector3& tip, const Vector3& marker) {
  RodShape rod;
  rod.tip = tip;
  rod.marker = marker;
  rod.bar = {marker, marker};
  return rod;
}

TEST(SessionShapes, ProjectsAPlaceWhereAPinholeWouldShowIt) {
  const SessionView view = a_calibrated_view();
  const auto projection = picture_projection(view, {0, 0, kWide, kHigh});
  ASSERT_TRUE(projection);
  // x/z = 0.1, y/z = -0.2 in the optical frame; half a pixel from a pixel's middle to its corner.
  const auto place = (*projection)({0.1, 0.2, 0.0});
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->x(), 319.5 + 50.0 + 0.5, 1e-9);
  EXPECT_NEAR(place->y(), 239.5 - 100.0 + 0.5, 1e-9);
  EXPECT_FALSE((*projection)({0.0, 0.0, 1.2}));  // behind the camera
}

TEST(SessionShapes, ScalesWithTheBoxThatThePictureFills) {
  const SessionView view = a_calibrated_view();
  const Box box{40, 30, 2 * kWide, 2 * kHigh};
  const auto small = (*picture_projection(view, {0, 0, kWide, kHigh}))({0.1, -0.1, 0.2});
  const auto large = (*picture_projection(view, box))({0.1, -0.1, 0.2});
  ASSERT_TRUE(small && large);
  EXPECT_NEAR(large->x(), 40.0 + 2.0 * small->x(), 1e-9);
  EXPECT_NEAR(large->y(), 30.0 + 2.0 * small->y(), 1e-9);
}

TEST(SessionShapes, ProjectsThroughTheLens) {
  SessionView view = a_calibrated_view();
  auto rig = *view.rig;
  rig.camera->model.distortion = {-0.2, 0.0, 0.0, 0.0, 0.0};
  view.rig = std::make_shared<rig::Rig>(rig);
  const auto place = (*picture_projection(view, {0, 0, kWide, kHigh}))({0.3, 0.0, 0.0});
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->x(), 320.0 + 500.0 * 0.3 * (1.0 - 0.2 * 0.09), 1e-6);
}

TEST(SessionShapes, TurnsWithTheHead) {
  SessionView view = a_calibrated_view();
  auto turned = std::make_shared<SessionPicture>(*view.picture);
  const double angle = 0.1;
  turned->marker.rotation = Quaternion(Eigen::AngleAxisd(angle, Vector3::UnitY()));  // to the left
  view.picture = turned;
  const auto place = (*picture_projection(view, {0, 0, kWide, kHigh}))({0.0, 0.0, 0.0});
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->x(), 320.0 + 500.0 * std::tan(angle), 1e-6);
}

TEST(SessionShapes, DrawsIntoNoPictureThatItCannotKnow) {
  SessionView view = a_calibrated_view();
  EXPECT_TRUE(picture_projection(view, {0, 0, kWide, kHigh}));
  auto rig = *view.rig;
  rig.hand_eye.reset();
  view.rig = std::make_shared<rig::Rig>(rig);
  EXPECT_FALSE(picture_projection(view, {0, 0, kWide, kHigh}));
  view = a_calibrated_view();
  auto hidden = std::make_shared<SessionPicture>(*view.picture);
  hidden->marker.seen = false;
  view.picture = hidden;
  EXPECT_FALSE(picture_projection(view, {0, 0, kWide, kHigh}));
  auto right = std::make_shared<SessionPicture>(*a_calibrated_view().picture);
  right->right = true;  // of a camera that is not calibrated
  view.picture = right;
  EXPECT_FALSE(picture_projection(view, {0, 0, kWide, kHigh}));
}

TEST(SessionShapes, HasTheTargetAndWhatThePersonHolds) {
  SessionView view = a_calibrated_view();
  view.request = pose_request({0.1, 0.2, 0.3});
  view.person.stylus.seen = true;
  view.person.stylus.rotation =
      Quaternion(Eigen::AngleAxisd(std::numbers::pi / 2.0, Vector3::UnitY()));  // its z is the world's x
  view.person.stylus.translation = {0.5, 0.0, 0.0};
  const SessionShapes shapes = shapes_of(view);
  ASSERT_TRUE(shapes.target && shapes.present && shapes.goal());
  EXPECT_TRUE(shapes.target->tip.isApprox(Vector3(0.1, 0.2, 0.3)));
  EXPECT_TRUE(shapes.target->marker.isApprox(Vector3(0.1, 0.2, 0.4)));
  EXPECT_TRUE(shapes.present->marker.isApprox(Vector3(0.5, 0.0, 0.0)));
  EXPECT_TRUE(shapes.present->tip.isApprox(Vector3(0.4, 0.0, 0.0)));
  // The bar lies along the marker's x axis.
  EXPECT_NEAR((shapes.present->bar[1] - shapes.present->bar[0]).normalized().z(), -1.0, 1e-12);
  view.person.stylus.seen = false;
  EXPECT_FALSE(shapes_of(view).present);
}

TEST(SessionShapes, ShowsWhereToTouchWhatTheRigHasAlready) {
  SessionView view = a_calibrated_view();
  auto rig = *view.rig;
  rig::SurfaceCalibration table;
  table.name = "table";
  table.width = 0.7;
  table.height = 0.5;
  table.X_world_rectangle.translation = {0.1, 0.0, 0.0};
  rig.surfaces.push_back(table);
  rig.landmarks.push_back({{Vector3(0.3, 0.2, 0.1)}});
  view.rig = std::make_shared<rig::Rig>(rig);
  view.request = device::Request{Gesture::touch, "table", 2};
  ASSERT_TRUE(shapes_of(view).goal());
  EXPECT_TRUE(shapes_of(view).goal()->isApprox(table.corner(2).m));
  EXPECT_EQ(shapes_of(view).surfaces.size(), 1u);
  view.request = device::Request{Gesture::touch, "landmark", 0};
  EXPECT_TRUE(shapes_of(view).goal()->isApprox(Vector3(0.3, 0.2, 0.1)));
  view.request = device::Request{Gesture::touch, "landmark", 1};
  EXPECT_FALSE(shapes_of(view).goal());
  view.request = device::Request{Gesture::touch, "wall", 0};
  EXPECT_FALSE(shapes_of(view).goal());
}

TEST(SessionShapes, KnowsWhenTheTipIsThere) {
  SessionView view = a_calibrated_view();
  auto rig = *view.rig;
  rig.pointer_pivot.emplace();
  rig.landmarks.push_back({{Vector3(0.3, 0.2, 0.1)}});
  view.rig = std::make_shared<rig::Rig>(rig);
  view.request = device::Request{Gesture::touch, "landmark", 0};
  view.person.pointer.seen = true;
  view.person.pointer.translation = {0.3, 0.2, 0.11};
  EXPECT_TRUE(is_near_goal(view, shapes_of(view)));
  view.person.pointer.translation = {0.3, 0.2, 0.13};
  EXPECT_FALSE(is_near_goal(view, shapes_of(view)));
  view.request = pose_request({0.1, 0.2, 0.3});  // as the session judges it
  EXPECT_FALSE(is_near_goal(view, shapes_of(view)));
  view.person.near_target = true;
  EXPECT_TRUE(is_near_goal(view, shapes_of(view)));
}

TEST(Plan, ShowsTheWorldFromAboveAndAsThePersonSeesIt) {
  SessionShapes shapes;
  shapes.target = rod_from({0.1, -1.3, 1.6}, {0.1, -1.2, 1.6});
  const Plan plan = plan_of(shapes);
  constexpr Size kSize{300, 300};
  const double scale = plan.pixels_per_metre(kSize);
  const auto above = plan.projection(kSize, PlanSide::above), front = plan.projection(kSize, PlanSide::front);
  const Vector3 here(0.1, -1.3, 1.6);
  const auto step = [&](const Projection& side, const Vector3& by) {
    return Eigen::Vector2d(*side(here + by) - *side(here));
  };
  EXPECT_TRUE(step(above, {0.1, 0, 0}).isApprox(Eigen::Vector2d(0.1 * scale, 0)));
  EXPECT_TRUE(
      step(above, {0, 0, 0.1}).isApprox(Eigen::Vector2d(0, 0.1 * scale)));  // towards the person: down
  EXPECT_LT(step(above, {0, 0.1, 0}).norm(), 1e-9);
  EXPECT_TRUE(step(front, {0, 0.1, 0}).isApprox(Eigen::Vector2d(0, -0.1 * scale)));  // up
  EXPECT_LT(step(front, {0, 0, 0.1}).norm(), 1e-9);
}

TEST(Plan, HoldsWhatHasToBeSeen) {
  SessionShapes shapes;
  shapes.target = rod_from({0.1, -1.3, 1.6}, {0.1, -1.2, 1.6});
  shapes.present = rod_from({0.6, -1.1, 1.2}, {0.6, -1.0, 1.2});
  shapes.held = {{-0.2, -1.4, 1.7}};
  const Plan plan = plan_of(shapes);
  constexpr Size kSize{320, 240};
  for (const PlanSide side : {PlanSide::above, PlanSide::front})
    for (const Vector3& point : {shapes.target->tip, shapes.target->marker, shapes.present->tip,
                                 shapes.present->marker, shapes.held[0]}) {
      const auto at = *plan.projection(kSize, side)(point);
      EXPECT_GT(at.x(), 0.0);
      EXPECT_GT(at.y(), 0.0);
      EXPECT_LT(at.x(), kSize.width);
      EXPECT_LT(at.y(), kSize.height);
    }
  // A hand that trembles does not move the plan.
  SessionShapes later = shapes;
  later.present->tip.x() += 0.001;
  EXPECT_EQ(plan_of(later).low, plan.low);
  EXPECT_EQ(plan_of(later).high, plan.high);
}

int count_of(const Canvas& canvas, const Colour& colour) {
  int count = 0;
  for (int y = 0; y < canvas.height; ++y)
    for (int x = 0; x < canvas.width; ++x)
      count += canvas.at(x, y) == std::array<std::uint8_t, 4>{colour.red, colour.green, colour.blue, 255};
  return count;
}

TEST(DrawShapes, MarksTheGoalWhereItIsAndTheTipBesideIt) {
  SessionShapes shapes;
  shapes.place = Vector3(100.0, 50.0, 0.0);
  shapes.present = rod_from({40.0, 50.0, 0.0}, {40.0, 20.0, 0.0});
  shapes.present->bar = {Vector3(30.0, 20.0, 0.0), Vector3(50.0, 20.0, 0.0)};
  const Projection flat = [](const Vector3& p) { return std::optional(Eigen::Vector2d(p.x(), p.y())); };
  Canvas canvas(200, 100);
  draw_shapes(canvas, shapes, flat, false, 16.0);
  EXPECT_EQ(canvas.at(100, 50), (std::array<std::uint8_t, 4>{kGoal.red, kGoal.green, kGoal.blue, 255}));
  EXPECT_EQ(canvas.at(40, 50),
            (std::array<std::uint8_t, 4>{kPresent.red, kPresent.green, kPresent.blue, 255}));
  EXPECT_GT(count_of(canvas, kGoal), 40);
  EXPECT_EQ(count_of(canvas, kGood), 0);
  Canvas arrived(200, 100);
  draw_shapes(arrived, shapes, flat, true, 16.0);
  EXPECT_GT(count_of(arrived, kGood), 40);
  EXPECT_EQ(count_of(arrived, kGoal), 0);
}

TEST(DrawShapes, PointsToAGoalBeyondTheEdge) {
  SessionShapes shapes;
  shapes.place = Vector3(1000.0, 50.0, 0.0);
  const Projection flat = [](const Vector3& p) { return std::optional(Eigen::Vector2d(p.x(), p.y())); };
  Canvas canvas(200, 100);
  draw_shapes(canvas, shapes, flat, false, 16.0);
  int left = 0, right = 0;
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 200; ++x) (x < 100 ? left : right) += canvas.at(x, y)[3] > 0;
  EXPECT_EQ(left, 0);
  EXPECT_GT(right, 100);
}

}  // namespace
}  // namespace palpate::desktop
