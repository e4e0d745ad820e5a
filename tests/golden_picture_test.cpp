// Pictures of ball, bat and arm beside those that a person has looked at.
#include <gtest/gtest.h>

#include "palpate/math/looking.h"
#include "tests/golden_picture_for_tests.h"
#include "tests/picture_scene_for_tests.h"

namespace palpate {
namespace {

const device::CameraModel kSmall{320, 240, 300, 300, 159.5, 119.5, {-0.2, 0.05, 0.001, -0.001, 0.0}};

device::CameraImage shaded_image() {  // a slow slope, so that lens and shadows show and the file stays small
  device::CameraImage image = even_image(kSmall, 0);
  for (int v = 0; v < 240; ++v)
    for (int u = 0; u < 320; ++u) {
      auto* p = &image.rgb[static_cast<std::size_t>(3 * (v * 320 + u))];
      p[0] = static_cast<std::uint8_t>(120 + u / 8), p[1] = static_cast<std::uint8_t>(130 + v / 8);
      p[2] = u / 32 % 2 == v / 32 % 2 ? 150 : 140;
    }
  return image;
}

struct Play {
  render::RealScene real = real_scene(true);
  scene::TriangleMesh ball = scene::sphere_mesh(0.020), front = scene::disc_mesh(0.075, 0.005, 48),
                      block = scene::box_mesh({-0.05, 0, -0.05}, {0.05, 0.08, 0.05});
  Vector3 tip = (real.arm->X_world_base * device::phantom_tip(real.arm->theta)).m;
  device::CameraImage image = shaded_image();
  scene::DrawItem bat() const {
    scene::DrawItem item = item_at(front, tip + Vector3(0, 0, -0.09), kRed);
    item.rotation = so3_exp(Vector3(1.1, 0.0, 0.2));
    return item;
  }
};

TEST(GoldenPicture, BallOnTheTableAndBatBehindTheArm) {
  Play play;
  const std::vector<scene::DrawItem> items{sphere_at(play.ball, 0.020, {-0.12, kTableHeight + 0.020, 1.45}),
                                           play.bat()};
  render::Compositor compositor;
  std::vector<std::uint8_t> rgb;
  compositor.draw(play.image, kSmall, kTestEye, items, play.real, rgb);
  compare_with_golden("ball-bat-arm", rgb, 320, 240);
}

TEST(GoldenPicture, BallBehindBatAndRegisteredBody) {
  Play play;
  play.real.bodies.push_back({&play.block, so3_exp(Vector3(0, 0.5, 0)), {-0.15, kTableHeight, 1.35}});
  const scene::DrawItem bat = play.bat();
  const Vector3 away = (bat.position - kTestEye.translation).normalized();
  const std::vector<scene::DrawItem> items{
      bat, sphere_at(play.ball, 0.020, bat.position + 0.09 * away + Vector3(-0.06, 0, 0)),
      sphere_at(play.ball, 0.020, {-0.17, kTableHeight + 0.05, 1.27})};
  render::CompositorSettings settings;
  settings.encoding = device::Encoding::srgb;
  render::Compositor compositor(settings);
  std::vector<std::uint8_t> rgb;
  compositor.draw(play.image, kSmall, kTestEye, items, play.real, rgb);
  compare_with_golden("ball-behind-bat", rgb, 320, 240);
}

TEST(GoldenPicture, FromOutside) {
  Play play;
  device::CameraModel camera = kSmall;
  const std::vector<scene::DrawItem> items{sphere_at(play.ball, 0.020, {-0.12, kTableHeight + 0.020, 1.45}),
                                           play.bat()};
  render::Compositor compositor;
  std::vector<std::uint8_t> rgb;
  const render::Viewpoint eye{nullptr, camera, looking({-1.0, -0.9, 2.2}, {0.0, -1.4, 1.4})};
  compositor.draw({&eye, 1}, items, play.real, rgb);
  compare_with_golden("from-outside", rgb, 320, 240);
}

}  // namespace
}  // namespace palpate
