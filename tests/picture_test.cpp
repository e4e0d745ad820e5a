// The simulated camera and what the graphics side makes of its pictures, together.
#include <gtest/gtest.h>

#include <cmath>

#include "palpate/math/looking.h"
#include "palpate/render/compositor.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/vision/landmark_detector.h"

namespace palpate {
namespace {

constexpr scene::Look kOrange{{0.86f, 0.30f, 0.035f}, 0.010f, 0.10f, 0.10f};

sim::TrueView laboratory() {
  sim::TrueView view;
  view.lens = {640, 480, 560, 561.5, 318.7, 242.1, {-0.28, 0.09, 0.001, -0.0005, 0.0}};
  view.X_world_camera = looking({0, -0.95, 2.30}, {0, -1.45, 1.40});
  view.table = {Vector3(-0.375, -1.52, 1.8), Vector3(0.375, -1.52, 1.8), Vector3(0.375, -1.52, 0.8),
                Vector3(-0.375, -1.52, 0.8)};
  view.wall = {Vector3(-0.375, -1.52, 0.8), Vector3(0.375, -1.52, 0.8), Vector3(0.375, -0.92, 0.8),
               Vector3(-0.375, -0.92, 0.8)};
  for (const double x : {-0.34, -0.12, 0.12, 0.34}) view.dots.push_back({{x, -1.52, 1.76}, Vector3::UnitY()});
  for (const double z : {1.30, 0.90}) {
    for (const double x : {-0.34, 0.34}) view.dots.push_back({{x, -1.52, z}, Vector3::UnitY()});
  }
  for (const double x : {-0.30, -0.1, 0.1, 0.30}) view.dots.push_back({{x, -1.12, 0.80}, Vector3::UnitZ()});
  view.X_world_base = {Quaternion::Identity(), {0.10, -1.40, 1.75}};
  view.theta = {0.1, 0.3, 0.2};
  view.X_tip_marker = {Quaternion::Identity(), {-0.004, 0.018, 0.118}};
  view.marker_leds = {{0.06, 0, 0}, {-0.03, 0.052, 0}, {-0.03, -0.052, 0}};
  view.noise_sd = 2.0;
  return view;
}

TEST(Picture, LandmarksAreFoundToATenthOfAPixelThroughLensNoiseAndArm) {
  sim::CameraRenderer renderer;
  sim::TrueView view = laboratory();
  std::vector<rig::Landmark> marks;
  for (const sim::Dot& dot : view.dots) {
    rig::Landmark mark;
    mark.place = {dot.centre};
    mark.normal = dot.normal;
    mark.diameter = dot.diameter;
    marks.push_back(mark);
  }
  device::CameraImage image;
  image.width = 640;
  image.height = 480;
  double squares = 0.0, worst = 0.0;
  int found = 0, predicted = 0;
  for (int frame = 0; frame < 10; ++frame) {
    const double t = 0.1 * frame;
    view.noise_seed = static_cast<std::uint64_t>(frame);
    view.X_world_camera = looking({0.05 * std::sin(7 * t), -0.95 + 0.03 * std::sin(11 * t), 2.30},
                                  {0.06 * std::sin(5 * t), -1.43, 1.40});
    view.theta = {0.4 * std::sin(4 * t), 0.3,
                  0.2 + 0.3 * std::sin(6 * t)};  // its shadow wanders over the dots
    renderer.render(view, image.rgb);
    // What the tracker alone would say: off by 0.2 degrees and 1 mm.
    Pose<World, CameraOptical> prior = view.X_world_camera;
    prior.rotation = so3_exp(Vector3(0.0025, -0.0025, 0.0015)) * prior.rotation;
    prior.translation += Vector3(0.0006, -0.0005, 0.0007);
    predicted += vision::predicted_landmarks(view.lens, prior, marks);
    for (const vision::LandmarkSighting& s : vision::detect_landmarks(image, view.lens, prior, marks)) {
      const Point<World> place = marks[s.landmark].place;
      const double error = (s.centre - view.lens.project((view.X_world_camera.inverse() * place).m)).norm();
      squares += error * error;
      worst = std::max(worst, error);
      ++found;
    }
  }
  EXPECT_GT(found, predicted * 7 / 10);  // the arm hides some
  EXPECT_LT(std::sqrt(squares / found), 0.1);
  EXPECT_LT(worst, 0.5);
}

TEST(Picture, AVirtualMarkerCoversTheRealDotItBelongsTo) {
  sim::CameraRenderer renderer;
  render::Compositor compositor({.shadows = false});
  sim::TrueView view = laboratory();
  view.noise_sd = 0.0;
  device::CameraImage image;
  image.width = 640;
  image.height = 480;
  renderer.render(view, image.rgb);
  const scene::TriangleMesh disc =
      scene::disc_mesh(0.0125, 0.0004, 48);  // a little larger than the dot with its ring
  std::vector<scene::DrawItem> items;
  for (const sim::Dot& dot : view.dots) {
    scene::DrawItem item;
    item.mesh = &disc;
    item.look = kOrange;
    item.rotation = rotation_between(Vector3::UnitY(), dot.normal);
    item.position = dot.centre + 0.0008 * dot.normal;
    items.push_back(item);
  }
  std::vector<std::uint8_t> rgb;
  compositor.draw(image, view.lens, view.X_world_camera, items, {}, rgb);
  for (const sim::Dot& dot : view.dots) {
    const device::Pixel p =
        view.lens.project_undistorted((view.X_world_camera.inverse() * Point<World>{dot.centre}).m);
    if (p.x() < 12 || p.y() < 12 || p.x() > 627 || p.y() > 467) continue;
    // Neither the bright disc nor its black ring shows anywhere round it.
    for (int v = -9; v <= 9; ++v) {
      for (int u = -9; u <= 9; ++u) {
        const std::uint8_t* at =
            &rgb[static_cast<std::size_t>(3 * ((std::lround(p.y()) + v) * 640 + std::lround(p.x()) + u))];
        EXPECT_FALSE(at[0] < 60 && at[1] < 60 && at[2] < 60) << "ring at " << u << ", " << v;
        EXPECT_FALSE(std::hypot(u, v) < 2 && at[0] > 200 && at[2] > 200) << "disc at " << u << ", " << v;
      }
    }
  }
}

}  // namespace
}  // namespace palpate
