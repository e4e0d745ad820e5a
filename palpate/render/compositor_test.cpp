#include "palpate/render/compositor.h"
#include "palpate/math/looking.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace palpate::render {
namespace {

const device::CameraModel kCamera{640, 480, 560, 561.5, 318.7, 242.1, {-0.28, 0.09, 0.001, -0.0005, 0.0}};

const Pose<World, CameraOptical> kEye = looking({0, -0.95, 2.30}, {0, -1.45, 1.40});

device::CameraImage grey_image(std::uint8_t level) {
  device::CameraImage image;
  image.width = kCamera.width;
  image.height = kCamera.height;
  image.rgb.assign(640u * 480u * 3u, level);
  return image;
}

RealScene table_and_wall() {
  RealScene real;
  real.surfaces = {
      {"table",
       {Vector3(-0.375, -1.52, 1.8), {0.375, -1.52, 1.8}, {0.375, -1.52, 0.8}, {-0.375, -1.52, 0.8}}},
      {"wall",
       {Vector3(-0.375, -1.52, 0.8), {0.375, -1.52, 0.8}, {0.375, -0.92, 0.8}, {-0.375, -0.92, 0.8}}}};
  return real;
}

scene::DrawItem ball_at(const scene::TriangleMesh& mesh, const Vector3& place) {
  scene::DrawItem item;
  item.mesh = &mesh;
  item.look = {{0.86f, 0.30f, 0.035f}, 0.010f, 0.10f, 0.10f};  // orange
  item.position = place;
  return item;
}

const std::uint8_t* pixel(const std::vector<std::uint8_t>& rgb, const device::Pixel& p) {
  return &rgb[static_cast<std::size_t>(3 * (std::lround(p.y()) * 640 + std::lround(p.x())))];
}

// Pixels that are no longer grey: their colour as weight.
device::Pixel coloured_middle(const std::vector<std::uint8_t>& rgb) {
  double sum = 0, x = 0, y = 0;
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 640; ++u) {
      const std::uint8_t* p = &rgb[static_cast<std::size_t>(3 * (v * 640 + u))];
      const double colour = p[0] > p[2] + 8 ? 1.0 : 0.0;
      sum += colour, x += colour * u, y += colour * v;
    }
  }
  return {x / sum, y / sum};
}

TEST(Compositor, DrawsThingsWhereTheCameraModelPutsThem) {
  Compositor compositor({.shadows = false});
  const device::CameraImage image = grey_image(40);
  std::vector<std::uint8_t> rgb;
  // Small enough that a sphere's outline is centred on its middle to 0.01 px, large enough to count pixels.
  const scene::TriangleMesh marker = scene::sphere_mesh(0.006, 24, 48);
  double worst = 0.0;
  Eigen::Vector2d bias = Eigen::Vector2d::Zero();
  int count = 0;
  for (double x = -0.3; x <= 0.31; x += 0.1487) {
    for (double z = 0.95; z <= 1.75; z += 0.1931) {
      const scene::DrawItem item = ball_at(marker, {x, -1.45 + 0.1 * x, z});
      compositor.draw(image, kCamera, kEye, {&item, 1}, {}, rgb);
      const device::Pixel expected =
          kCamera.project_undistorted((kEye.inverse() * Point<World>{item.position}).m);
      const Eigen::Vector2d error = coloured_middle(rgb) - expected;
      worst = std::max(worst, error.norm());
      bias += error;
      ++count;
    }
  }
  // 40 to 60 whole pixels and their four samples each carry a place of about 0.05 px.
  EXPECT_LT(worst, 0.2);
  EXPECT_LT((bias / count).norm(), 0.03);  // a half-pixel mistake or a flip would be 0.5 or more
}

TEST(Compositor, UndoesTheLensOfTheBackground) {
  Compositor compositor;
  device::CameraImage image = grey_image(0);
  // A smooth spot round each distorted place; its middle must come out at the undistorted one.
  for (const Vector3& p : {Vector3(0.42, 0.3, 1), Vector3(-0.45, 0.2, 1), Vector3(0.05, -0.35, 1)}) {
    const device::Pixel seen = kCamera.project(p);
    image.rgb.assign(image.rgb.size(), 0);
    for (int v = 0; v < 480; ++v) {
      for (int u = 0; u < 640; ++u) {
        const double level = 250.0 * std::exp(-(device::Pixel(u, v) - seen).squaredNorm() / 8.0);
        for (std::size_t c = 0; c < 3; ++c) {
          image.rgb[static_cast<std::size_t>(3 * (v * 640 + u)) + c] =
              static_cast<std::uint8_t>(std::lround(level));
        }
      }
    }
    std::vector<std::uint8_t> rgb;
    compositor.draw(image, kCamera, {}, {}, {}, rgb);
    double sum = 0, x = 0, y = 0;
    for (int v = 0; v < 480; ++v) {
      for (int u = 0; u < 640; ++u) {
        const double w = rgb[static_cast<std::size_t>(3 * (v * 640 + u))];
        sum += w, x += w * u, y += w * v;
      }
    }
    // Stretching is uneven across the spot (2 px wide): up to 0.04 px near the corners.
    EXPECT_LT((device::Pixel(x / sum, y / sum) - kCamera.project_undistorted(p)).norm(), 0.06);
  }
}

// By the processor and by the renderer, with a ball, its shadow and a noisy image, for two eyes of two lenses.
TEST(Compositor, TheLensIsUndoneAlikeByTheProcessorAndTheRenderer) {
  device::CameraImage image = grey_image(40);
  for (std::size_t i = 0; i < image.rgb.size(); ++i)
    image.rgb[i] = static_cast<std::uint8_t>(40 + (i * 7919) % 23);
  device::CameraModel other = kCamera, wide = kCamera, rational = kCamera;
  other.distortion[0] = -0.2;
  wide.kind = device::LensKind::fisheye;
  wide.distortion = {0.02, -0.01, 0.004, -0.0009, 0.0};
  rational.kind = device::LensKind::rational;
  rational.distortion = {0.45, 0.05, 0.0006, -0.0004, 0.002, 0.78, 0.17, 0.011};
  const scene::TriangleMesh ball = scene::sphere_mesh(0.02, 24, 48);
  const scene::DrawItem item = ball_at(ball, {0.05, -1.49, 1.4});
  for (const auto& [samples, second] :
       {std::pair{1, other}, std::pair{4, other}, std::pair{4, wide}, std::pair{4, rational}}) {
    const std::vector<Viewpoint> eyes{{&image, kCamera, kEye}, {&image, second, kEye}};
    std::vector<std::uint8_t> by_processor, by_renderer, nothing;
    Compositor({.samples = samples, .lens_on_processor = true})
        .draw(eyes, {&item, 1}, table_and_wall(), by_processor);
    Compositor({.samples = samples, .lens_on_processor = false})
        .draw(eyes, {&item, 1}, table_and_wall(), by_renderer);
    Compositor({.samples = samples}).draw(eyes, {}, table_and_wall(), nothing);
    ASSERT_EQ(by_processor.size(), by_renderer.size());
    int farthest = 0, drawn = 0;
    for (std::size_t i = 0; i < by_processor.size(); ++i) {
      farthest = std::max(farthest, std::abs(by_processor[i] - by_renderer[i]));
      drawn += std::abs(by_processor[i] - nothing[i]) > 10;
    }
    EXPECT_LE(farthest, 2) << samples;
    EXPECT_GT(drawn, 2000) << "the ball and its shadow";
  }
}

TEST(Compositor, RealThingsHideVirtualOnes) {
  Compositor compositor({.shadows = false});
  const device::CameraImage image = grey_image(90);
  const scene::TriangleMesh mesh = scene::sphere_mesh(0.02);
  RealScene real = table_and_wall();
  std::vector<std::uint8_t> plain, rgb;
  compositor.draw(image, kCamera, kEye, {}, real, plain);
  const scene::DrawItem under = ball_at(mesh, {0.1, -1.56, 1.4}), behind = ball_at(mesh, {0.0, -1.3, 0.75});
  for (const scene::DrawItem& item : {under, behind}) {
    compositor.draw(image, kCamera, kEye, {&item, 1}, real, rgb);
    EXPECT_EQ(rgb, plain);
  }
  // The arm: a ball on the line from the eye through the stylus' tip, once before and once behind it.
  ArmConfiguration arm;
  arm.X_world_base = {Quaternion::Identity(), {0.10, -1.40, 1.75}};
  arm.theta = {0.1, 0.3, 0.2};
  real.arm = arm;
  const Vector3 tip = (arm.X_world_base * device::phantom_tip(arm.theta)).m, eye = kEye.translation;
  const scene::TriangleMesh small = scene::sphere_mesh(0.005);
  scene::DrawItem item = ball_at(small, tip + 0.06 * (tip - eye).normalized());
  compositor.draw(image, kCamera, kEye, {&item, 1}, real, rgb);
  EXPECT_EQ(rgb, plain);
  item.position = tip - 0.06 * (tip - eye).normalized();
  compositor.draw(image, kCamera, kEye, {&item, 1}, real, rgb);
  EXPECT_NE(rgb, plain);
}

TEST(Compositor, VirtualThingsThrowShadowsOnRealSurfaces) {
  CompositorSettings settings;
  Compositor compositor(settings);
  const device::CameraImage image = grey_image(150);
  const scene::TriangleMesh mesh = scene::sphere_mesh(0.02);
  const scene::DrawItem item = ball_at(mesh, {-0.1, -1.40, 1.4});
  std::vector<std::uint8_t> plain, rgb;
  compositor.draw(image, kCamera, kEye, {}, table_and_wall(), plain);
  compositor.draw(image, kCamera, kEye, {&item, 1}, table_and_wall(), rgb);
  const Vector3 lamp = settings.light.lamp;
  const Vector3 foot = lamp + (item.position - lamp) * ((lamp.y() + 1.52) / (lamp.y() - item.position.y()));
  const device::Pixel dark = kCamera.project_undistorted((kEye.inverse() * Point<World>{foot}).m);
  EXPECT_LT(*pixel(rgb, dark), 0.8 * *pixel(plain, dark));
  EXPECT_EQ(*pixel(rgb, dark + device::Pixel(80, 0)), *pixel(plain, dark + device::Pixel(80, 0)));
  // A thing told not to throw one does not.
  scene::DrawItem quiet = item;
  quiet.casts_shadow = false;
  compositor.draw(image, kCamera, kEye, {&quiet, 1}, table_and_wall(), rgb);
  EXPECT_EQ(*pixel(rgb, dark), *pixel(plain, dark));
}

TEST(Compositor, IsTheSameToTheBitWhateverWasDrawnBefore) {
  const device::CameraImage image = grey_image(120);
  scene::TriangleMesh mesh = scene::sphere_mesh(0.02);
  const scene::DrawItem item = ball_at(mesh, {0.1, -1.45, 1.3}), elsewhere = ball_at(mesh, {-0.2, -1.3, 1.6});
  std::vector<std::uint8_t> first, again;
  Compositor a, b;
  a.draw(image, kCamera, kEye, {&item, 1}, table_and_wall(), first);
  b.draw(image, kCamera, kEye, {&elsewhere, 1}, table_and_wall(), again);
  b.draw(image, kCamera, kEye, {&item, 1}, table_and_wall(), again);
  EXPECT_EQ(first, again);
  // A mesh that changes its shape in place is seen to change.
  for (Vector3& v : mesh.vertices) v.y() *= 0.5;
  mesh.version.raise();
  b.draw(image, kCamera, kEye, {&item, 1}, table_and_wall(), again);
  EXPECT_NE(first, again);
}

TEST(Compositor, RefusesAnImageOfAnotherSize) {
  Compositor compositor;
  device::CameraImage image = grey_image(0);
  image.height = 479;
  std::vector<std::uint8_t> rgb;
  EXPECT_THROW(compositor.draw(image, kCamera, {}, {}, {}, rgb), std::invalid_argument);
  EXPECT_THROW(Compositor({.samples = 3}), std::invalid_argument);
  EXPECT_THROW(Compositor({.surface_texels = 8}), std::invalid_argument);
  EXPECT_THROW(Compositor({.map_texels = 32}), std::invalid_argument);
}

TEST(Quality, IsReadByItsWordAndChangesThePicture) {
  for (const Quality quality : {Quality::low, Quality::medium, Quality::high})
    EXPECT_EQ(*parse_quality(quality_word(quality)), quality);
  const auto wrong = parse_quality("ultra");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().exit_code(), 2);
  EXPECT_EQ(wrong.error().message, "--quality 'ultra': low, medium or high is expected");
  const device::CameraImage image = grey_image(120);
  const scene::TriangleMesh mesh = scene::sphere_mesh(0.02);
  const scene::DrawItem item = ball_at(mesh, {0.1, -1.45, 1.3});
  std::vector<std::vector<std::uint8_t>> drawn(3);
  for (const Quality quality : {Quality::low, Quality::medium, Quality::high})
    Compositor(settings_of(quality))
        .draw(image, kCamera, kEye, {&item, 1}, table_and_wall(), drawn[static_cast<std::size_t>(quality)]);
  EXPECT_NE(drawn[0], drawn[1]);
  EXPECT_NE(drawn[1], drawn[2]);
}

}  // namespace
}  // namespace palpate::render
