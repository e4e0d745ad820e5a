// Two eyes: the virtual things each sees beside real ones at the same places, drawn by the simulated cameras.
#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/random.h"
#include "palpate/render/compositor.h"
#include "palpate/sim/camera_renderer.h"
#include "palpate/sim/simulator.h"
#include "palpate/vision/landmark_detector.h"
#include "palpate/vision/pose_refinement.h"

namespace palpate {
namespace {

constexpr scene::Look kOrange{{0.86f, 0.30f, 0.035f}, 0.010f, 0.10f, 0.10f};

constexpr double kApart = 0.064;  // m between the eyes

// Left and right camera, each with a lens of its own, the right one turned a little inwards.
struct TwoCameras {
  device::CameraModel left{640, 480, 560, 561.5, 318.7, 242.1, {-0.28, 0.09, 0.001, -0.0005, 0.0}};
  device::CameraModel right{640, 480, 566, 565.0, 322.9, 236.4, {-0.25, 0.07, -0.0006, 0.0008, 0.01}};
  Pose<CameraOptical, CameraOptical> right_in_left{so3_exp(Vector3(0.004, -0.03, 0.002)),
                                                   {kApart, 0.0006, -0.0011}};
};

sim::TrueView laboratory(const sim::Simulator& world) {
  sim::TrueView view = world.true_view();
  view.noise_sd = 0.0;
  view.board.reset();
  return view;
}

device::CameraImage picture_of(sim::CameraRenderer& renderer, const sim::TrueView& view) {
  device::CameraImage image;
  image.width = view.lens.width, image.height = view.lens.height;
  renderer.render(view, image.rgb);
  return image;
}

// Middle of the pixels in which two pictures differ, in one eye's part; clear differences count alike, so
// that it is the outline that counts.
device::Pixel middle_of_change(const std::vector<std::uint8_t>& a, const std::vector<std::uint8_t>& b,
                               int eye) {
  double sum = 0, x = 0, y = 0;
  for (int v = 0; v < 480; ++v)
    for (int u = 0; u < 640; ++u) {
      const auto at = static_cast<std::size_t>(3 * (v * 1280 + 640 * eye + u));
      const auto orange = [at](const std::vector<std::uint8_t>& rgb) {
        return static_cast<double>(rgb[at]) - rgb[at + 2];
      };
      const double w = std::clamp((orange(a) - orange(b) - 20.0) / 40.0, 0.0, 1.0);
      sum += w, x += w * u, y += w * v;
    }
  return {x / sum, y / sum};
}

TEST(Stereo, AVirtualBallHasTheDisparityOfARealOneAtItsPlace) {
  const sim::Simulator world(sim::config::reference_world(), 2);
  const TwoCameras cameras;
  sim::CameraRenderer renderer;
  render::Compositor compositor(render::CompositorSettings{.shadows = false});
  const scene::TriangleMesh ball = scene::sphere_mesh(0.020, 48, 96);
  sim::TrueView view = laboratory(world);
  view.X_world_base.translation.x() += 3.0;  // no arm in the picture
  const auto left = view.X_world_camera;
  const auto right = left * cameras.right_in_left;
  double squares = 0.0, worst = 0.0;
  int count = 0;
  for (const double z : {0.95, 1.3, 1.6})
    for (const double across : {-0.2, 0.0, 0.2}) {
      // Pictures without and with a real ball there, over the blue table.
      const Vector3 place(across, -1.48, z);
      std::vector<device::CameraImage> without, with;
      for (const auto& [lens, pose] : {std::pair{&cameras.left, &left}, std::pair{&cameras.right, &right}}) {
        view.lens = *lens, view.X_world_camera = *pose;
        view.balls.clear();
        without.push_back(picture_of(renderer, view));
        view.balls.push_back({place, 0.020});
        with.push_back(picture_of(renderer, view));
      }
      scene::DrawItem item;
      item.mesh = &ball;
      item.look = kOrange;
      item.position = place;
      const std::vector<render::Viewpoint> plain{{&without[0], cameras.left, left},
                                                 {&without[1], cameras.right, right}};
      const std::vector<render::Viewpoint> real{{&with[0], cameras.left, left},
                                                {&with[1], cameras.right, right}};
      std::vector<std::uint8_t> empty_rgb, virtual_rgb, real_rgb;
      compositor.draw(plain, {}, {}, empty_rgb);
      compositor.draw(plain, {&item, 1}, {}, virtual_rgb);
      compositor.draw(real, {}, {}, real_rgb);
      std::array<device::Pixel, 2> seen_virtual, seen_real;
      for (int eye = 0; eye < 2; ++eye) {
        seen_virtual[static_cast<std::size_t>(eye)] = middle_of_change(virtual_rgb, empty_rgb, eye);
        seen_real[static_cast<std::size_t>(eye)] = middle_of_change(real_rgb, empty_rgb, eye);
      }
      const device::Pixel disparity_virtual = seen_virtual[0] - seen_virtual[1];
      const device::Pixel disparity_real = seen_real[0] - seen_real[1];
      // Known without any picture: a ball of one colour has its middle where its centre is projected, to the
      // 0.05 px by which a sphere's outline is no circle, seen aside.
      const device::Pixel expected =
          cameras.left.project_undistorted((left.inverse() * Point<World>{place}).m) -
          cameras.right.project_undistorted((right.inverse() * Point<World>{place}).m);
      EXPECT_NEAR((disparity_virtual - expected).norm(), 0.0, 0.3);
      const double error = (disparity_virtual - disparity_real).norm();
      squares += error * error;
      worst = std::max(worst, error);
      ++count;
    }
  EXPECT_LT(worst, 0.3);
  RecordProperty("disparity_rms_px", std::to_string(std::sqrt(squares / count)));
  RecordProperty("disparity_worst_px", std::to_string(worst));
}

TEST(Stereo, EyesSideBySideAreTheirOwnPicturesToTheBit) {
  const sim::Simulator world(sim::config::reference_world(), 2);
  const TwoCameras cameras;
  sim::CameraRenderer renderer;
  sim::TrueView view = laboratory(world);
  const auto left = view.X_world_camera;
  const auto right = left * cameras.right_in_left;
  view.lens = cameras.left;
  const device::CameraImage left_image = picture_of(renderer, view);
  view.lens = cameras.right, view.X_world_camera = right;
  const device::CameraImage right_image = picture_of(renderer, view);
  const scene::TriangleMesh ball = scene::sphere_mesh(0.020);
  scene::DrawItem item;
  item.mesh = &ball;
  item.look = kOrange;
  item.position = {-0.05, -1.44, 1.4};
  render::RealScene real;
  real.surfaces = {{"table", view.table}, {"wall", view.wall}};
  render::Compositor compositor;
  std::vector<std::uint8_t> both, one, other;
  const std::vector<render::Viewpoint> eyes{{&left_image, cameras.left, left},
                                            {&right_image, cameras.right, right}};
  compositor.draw(eyes, {&item, 1}, real, both);
  compositor.draw(left_image, cameras.left, left, {&item, 1}, real, one);
  compositor.draw(right_image, cameras.right, right, {&item, 1}, real, other);
  ASSERT_EQ(both.size(), 2 * one.size());
  for (std::size_t row = 0; row < 480; ++row) {
    ASSERT_TRUE(std::equal(&one[row * 1920], &one[row * 1920] + 1920, &both[row * 3840])) << row;
    ASSERT_TRUE(std::equal(&other[row * 1920], &other[row * 1920] + 1920, &both[row * 3840 + 1920])) << row;
  }
  EXPECT_NE(one, other);
  // One camera for two eyes: the same twice.
  const auto twice = render::biocular(one, 640, 480);
  for (std::size_t row = 0; row < 480; ++row)
    ASSERT_TRUE(std::equal(&twice[row * 3840], &twice[row * 3840] + 1920, &twice[row * 3840 + 1920])) << row;
  EXPECT_EQ(render::left_eye(both, 1280, 480, 2), one);
  EXPECT_EQ(render::left_eye(one, 640, 480, 1), one);
  EXPECT_THROW(render::biocular(one, 640, 481), std::invalid_argument);
  EXPECT_THROW(render::left_eye(both, 1280, 481, 2), std::invalid_argument);
  EXPECT_THROW(render::left_eye(both, 1280, 480, 3), std::invalid_argument);
  device::CameraModel wide = cameras.right;
  wide.width = 641;
  const std::vector<render::Viewpoint> unequal{{&left_image, cameras.left, left}, {nullptr, wide, right}};
  EXPECT_THROW(compositor.draw(unequal, {}, real, both), std::invalid_argument);
  EXPECT_THROW(compositor.draw(std::span<const render::Viewpoint>(), {}, real, both), std::invalid_argument);
}

// Lenses, hand-eyes and landmarks as calibrations leave them, the tracker's pose as it measures; each eye's
// pose refined by its own picture. Errors of surveyed points that no refinement uses.
TEST(Stereo, EachEyesOverlayIsTrueToAThirdOfAPixel) {
  const TwoCameras truth;
  sim::CameraRenderer renderer;
  std::array<double, 2> squares{}, squares_tracker{};
  std::array<int, 2> points{};
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    sim::Simulator world(sim::config::reference_world(), seed);
    sim::TrueView view = laboratory(world);
    view.noise_sd = world.file().camera.noise_sd;
    Random random(seed, "calibration");
    const auto some = [&](double sd) {
      return Vector3(sd * random.normal(), sd * random.normal(), sd * random.normal());
    };
    std::vector<rig::Landmark> landmarks;
    for (const auto& dot : view.dots)
      landmarks.push_back({{dot.centre + some(1e-4)}, 1e-8 * Matrix3::Identity(), dot.normal, dot.diameter});
    const auto head = world.true_state().X_world_camera;
    for (int eye = 0; eye < 2; ++eye) {
      const auto e = static_cast<std::size_t>(eye);
      view.lens = eye == 0 ? truth.left : truth.right;
      view.X_world_camera = eye == 0 ? head : head * truth.right_in_left;
      view.noise_seed = seed + 100 * e;
      const device::CameraImage image = picture_of(renderer, view);
      device::CameraModel lens = view.lens;
      lens.fx += 0.3 * random.normal(), lens.fy += 0.3 * random.normal();
      lens.cx += 0.2 * random.normal(), lens.cy += 0.2 * random.normal();
      // Tracker and hand-eye together: 0.15 deg and 0.5 mm per axis.
      vision::CameraPosePrior prior;
      prior.X_world_camera = {so3_exp(some(0.0026)) * view.X_world_camera.rotation,
                              view.X_world_camera.translation + some(5e-4)};
      prior.covariance.diagonal() << Vector3::Constant(0.0026 * 0.0026), Vector3::Constant(25e-8);
      std::vector<vision::Sighting> sightings;
      for (const auto& s : vision::detect_landmarks(image, lens, prior.X_world_camera, landmarks))
        sightings.push_back({s.landmark, s.centre});
      const vision::RefinedPose refined = vision::refine_camera_pose(lens, prior, landmarks, sightings);
      ASSERT_TRUE(refined.refined) << seed << " " << eye;
      for (const Vector3& p : world.truth().check_points) {
        const auto pixel_in = [&](const Pose<World, CameraOptical>& X) {
          return lens.project_undistorted((X.inverse() * Point<World>{p}).m);
        };
        const Vector3 q = (view.X_world_camera.inverse() * Point<World>{p}).m;
        if (q.z() < 0.1) continue;
        const device::Pixel seen = view.lens.project(q);
        if (seen.x() < 0 || seen.y() < 0 || seen.x() > 639 || seen.y() > 479) continue;
        const auto real = lens.undistort_pixel(seen);
        ASSERT_TRUE(real);
        squares[e] += (pixel_in(refined.X_world_camera) - *real).squaredNorm();
        squares_tracker[e] += (pixel_in(prior.X_world_camera) - *real).squaredNorm();
        ++points[e];
      }
    }
  }
  for (const std::size_t eye : {0u, 1u}) {
    ASSERT_GT(points[eye], 60);
    EXPECT_LT(std::sqrt(squares[eye] / points[eye]), 0.3) << eye;
    EXPECT_GT(std::sqrt(squares_tracker[eye] / points[eye]), 1.0) << eye;  // what refinement is worth
    RecordProperty(eye == 0 ? "left_world_px" : "right_world_px",
                   std::to_string(std::sqrt(squares[eye] / points[eye])));
  }
}

}  // namespace
}  // namespace palpate
