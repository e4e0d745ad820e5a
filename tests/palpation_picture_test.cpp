// The dent in the picture beside the force model's: where the tip presses, the drawn surface lies as deep.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "applications/palpation/organ_for_tests.h"
#include "applications/palpation/palpation.h"
#include "applications/palpation/scene_view.h"
#include "palpate/math/looking.h"
#include "palpate/render/compositor.h"
#include "palpate/scene/mesh_normals.h"
#include "tests/golden_picture_for_tests.h"

namespace palpate::applications::palpation {
namespace {

constexpr double kPixels = 560.0;    // of the reference laboratory's camera, for a ray of slope 1
constexpr double kEyeAway_m = 0.62;  // as far as a person looks from
constexpr double kFiner = 8.0;       // the test's camera has so many pixels for one of that
constexpr double kMarkRadius_m = 0.0003;
constexpr Duration kTick = std::chrono::milliseconds(1);

// The organ pressed at one place, as the physics loop leaves it.
struct Pressed {
  scene::SceneState state;
  std::shared_ptr<const scene::Shape> shape;
  Vector3 touched = Vector3::Zero(),
          normal = Vector3::Zero();  // World: the force model's lowest place, out of it
  double depth = 0.0;                // m, the force model's
};

// `application`: of `scene`; its clock goes on from `ticks`.
Pressed pressed(const scene::SceneDescription& scene, PalpationApplication& application, int& ticks,
                double aside_x, double aside_z, double depth) {
  const auto mesh = pressed_mesh(scene);
  const auto normals = scene::vertex_normals(mesh);
  std::size_t nearest = 0;
  const auto away = [&](std::size_t i) {
    return std::hypot(mesh.vertices[i].x() - aside_x, mesh.vertices[i].z() - aside_z) +
           (normals[i].y() > 0.3 ? 0.0 : 1.0);
  };
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    if (away(i) < away(nearest)) nearest = i;
  const PalpationSettings settings = palpation_settings(scene);
  const Pose<World, Body> X = application.rest();
  const Vector3 place = (X * Point<Body>{mesh.vertices[nearest]}).m, out = X.rotation * normals[nearest];
  Pressed result;
  scene::TipState tip;
  for (int i = 1; i <= 900; ++i) {  // down, and held
    tip.time = Instant<PhysicsClock>{++ticks * kTick};
    const double above = 0.02 * std::max(0.0, 1.0 - i / 400.0);
    tip.X_world_tip.translation = place + (settings.tip_radius - depth + above) * out;
    application.contact_law()->force(tip, to_seconds(kTick));
    application.step(tip.time, kTick, tip, result.state);
  }
  result.depth = 1e-6 * result.state.counters[kDepthUm];
  result.touched = Vector3(result.state.continuous.point.data());
  result.normal = (tip.X_world_tip.translation - result.touched).normalized();
  result.shape = std::make_shared<const scene::Shape>(
      scene::Shape{result.state.time, {application.shape().begin(), application.shape().end()}});
  return result;
}

// The organ alone, looked at from `eye`; a small mark at `mark`. How many pixels of the mark are seen.
class MarkedPicture {
 public:
  MarkedPicture(const Pressed& organ, const scene::SceneDescription& scene, const Vector3& eye)
      : view_(scene), X_world_camera_(looking(eye, organ.touched)) {
    camera_ = {320, 240, kFiner * kPixels, kFiner * kPixels, 159.5, 119.5, {}};
    image_.width = camera_.width, image_.height = camera_.height;
    image_.rgb.assign(3u * 320u * 240u, 90);
    view_.set_shape(organ.shape);
    items_ = view_.draw(organ.state);
    items_.resize(1);  // the organ comes first
    scene::deform(items_, organ.shape);
    without_ = drawn(items_);
  }
  int seen(const Vector3& mark) {
    auto items = items_;
    scene::DrawItem ball;
    ball.mesh = &ball_;
    ball.position = mark;
    ball.look = {{0.1f, 0.9f, 0.1f}};
    items.push_back(ball);
    const auto with = drawn(items);
    int count = 0;
    for (std::size_t i = 0; i < with.size(); i += 3)
      count += !std::equal(&with[i], &with[i] + 3, &without_[i]);
    return count;
  }

 private:
  std::vector<std::uint8_t> drawn(const std::vector<scene::DrawItem>& items) {
    std::vector<std::uint8_t> rgb;
    compositor_.draw(image_, camera_, X_world_camera_, items, {}, rgb);
    return rgb;
  }
  PalpationView view_;
  Pose<World, CameraOptical> X_world_camera_;
  device::CameraModel camera_;
  device::CameraImage image_{};
  std::vector<scene::DrawItem> items_;
  std::vector<std::uint8_t> without_;
  scene::TriangleMesh ball_ = scene::sphere_mesh(kMarkRadius_m, 12, 24);
  render::Compositor compositor_{render::CompositorSettings{.samples = 1, .shadows = false}};
};

// A mark out of the surface by what is a pixel in the laboratory's picture is seen, one as far inside is not.
TEST(PalpationPicture, DentIsAsDeepUnderTheTipAsTheForceModelsToAPixel) {
  const scene::SceneDescription scene =
      with(table_for_tests(), "palpation.element_mm", std::vector<double>{16.0});
  PalpationApplication application(scene, {}, {});
  int ticks = 0;
  for (const auto& [x, z] : {std::pair{0.0, 0.0}, std::pair{-0.025, 0.015}, std::pair{0.03, -0.012}})
    for (const double depth : {0.002, 0.0055}) {
      const Pressed organ = pressed(scene, application, ticks, x, z, depth);
      ASSERT_NEAR(organ.depth, depth, 3e-4);
      const Vector3 side = organ.normal.cross(Vector3::UnitX()).normalized();
      const double slope = 0.9;  // rad, of the look from the normal
      const Vector3 eye =
          organ.touched + kEyeAway_m * (std::cos(slope) * organ.normal - std::sin(slope) * side);
      // Along the normal, so far that it is a pixel across the look.
      const double pixel = kEyeAway_m / kPixels / std::sin(slope);
      MarkedPicture picture(organ, scene, eye);
      EXPECT_GT(picture.seen(organ.touched + pixel * organ.normal), 8) << x << ' ' << depth;
      EXPECT_EQ(picture.seen(organ.touched - pixel * organ.normal), 0) << x << ' ' << depth;
    }
}

// Veins are there, and where the tip presses it is paler than at rest.
TEST(PalpationPicture, SurfaceIsPalerWhereItIsPressedAndStressedThereMost) {
  const scene::SceneDescription scene =
      with(table_for_tests(), "palpation.element_mm", std::vector<double>{16.0});
  PalpationApplication application(scene, {}, {});
  int ticks = 0;
  const Pressed organ = pressed(scene, application, ticks, 0.0, 0.0, 0.0055);
  const OrganTint tint(pressed_mesh(scene), {});
  const TintPress press{organ.touched, organ.depth, 1e-3 * organ.state.counters[kForceMn], 0.006};
  const auto rest = tint.living(nullptr, {});
  const auto now = tint.living(organ.shape.get(), press);
  EXPECT_GT(*std::max_element(rest->shares.begin(), rest->shares.end()), 0.5f) << "no veins";
  EXPECT_GE(*std::min_element(rest->shares.begin(), rest->shares.end()), 0.0f);
  const auto stressed = tint.stress(organ.shape.get(), press);
  EXPECT_GT(OrganTint::largest(*stressed), 0.5);
  EXPECT_EQ(OrganTint::largest(*tint.stress(nullptr, {})), 0.0);
  for (std::size_t i = 0; i < now->shares.size(); ++i) {
    const Vector3 at = Eigen::Map<const Eigen::Vector3f>(&organ.shape->values[6 * i]).cast<double>();
    const double off = (at - organ.touched).norm();
    if (off < 0.004) {
      EXPECT_LT(now->shares[i], -0.6f) << off;
    }
    if (off > 0.030) {
      EXPECT_EQ(now->shares[i], rest->shares[i]) << off;
      EXPECT_LT(stressed->shares[i], 0.5f) << off;
    }
  }
}

// As a person has looked at it: pressed; its net with the nodules and a mark, once a search is over; its stress.
TEST(PalpationPicture, OrganLooksAsItDidToWhoLookedAtIt) {
  const scene::SceneDescription scene =
      with(table_for_tests(), "palpation.element_mm", std::vector<double>{16.0});
  PalpationApplication application(scene, {}, {});
  int ticks = 0;
  Pressed organ = pressed(scene, application, ticks, -0.01, 0.01, 0.0055);
  const device::CameraModel camera{320, 240, 900, 900, 159.5, 119.5, {}};
  const auto X_world_camera = looking(organ.touched + Vector3(0.05, 0.33, 0.30), organ.touched);
  device::CameraImage image;
  image.width = camera.width, image.height = camera.height;
  image.rgb.assign(3u * 320u * 240u, 150);
  render::RealScene real;
  real.surfaces = scene.surfaces;
  PalpationView view(scene);
  view.set_shape(organ.shape);
  render::Compositor compositor;
  const auto compare = [&](const char* name) {
    auto items = view.draw(organ.state);
    scene::deform(items, organ.shape);
    std::vector<std::uint8_t> rgb;
    compositor.draw(image, camera, X_world_camera, items, real, rgb);
    compare_with_golden(name, rgb, camera.width, camera.height, Golden::alike);
  };
  compare("organ-pressed");
  view.set_look(2);
  compare("organ-stressed");
  view.set_look(0);
  organ.state.counters[kPhase] = static_cast<std::int32_t>(TrialPhase::shown);
  organ.state.counters[kNoduleSeed] = 7;
  auto& mark = organ.state.bodies[kFirstMark];
  mark.visible = 1;
  mark.set_p(organ.touched + Vector3(0.03, 0.0, 0.0));
  compare("organ-searched");
}

}  // namespace
}  // namespace palpate::applications::palpation
