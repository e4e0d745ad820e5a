#include <gtest/gtest.h>

#include <algorithm>

#include "palpate/scene/generic_view.h"
#include "tests/picture_scene_for_tests.h"

namespace palpate::render {
namespace {

// The corner between the three axes looks at the eye: each pin is seen at its place in its colour, before the
// grey of the sphere.
TEST(GenericViewPicture, TellsABodysAxesByTheirColours) {
  const double radius = 0.04;
  const scene::GenericView view("unheard-of", 0, radius);
  const Vector3 place(0.0, kTableHeight + 0.15, 1.5);
  const Vector3 to_eye = (kTestEye.translation - place).normalized();
  Compositor compositor;
  std::vector<std::uint8_t> rgb;
  for (const double turn : {0.0, 2.0, 4.0}) {  // rad, about the line of sight
    scene::SceneState state;
    state.body_count = 1;
    state.bodies[0].set_p(place);
    state.bodies[0].set_q(so3_exp(turn * to_eye) * rotation_between(Vector3::Ones().normalized(), to_eye));
    const auto items = view.draw(state);
    compositor.draw(even_image(kTestCamera, 200), kTestCamera, kTestEye, items, real_scene(false), rgb);
    const auto at = [&](const Vector3& in_body) {
      const Vector3 p = place + state.bodies[0].q() * in_body;
      const device::Pixel pixel = kTestCamera.project_undistorted((kTestEye.inverse() * Point<World>{p}).m);
      const auto* bytes = pixel_of(rgb, kTestCamera, static_cast<int>(std::lround(pixel.x())),
                                   static_cast<int>(std::lround(pixel.y())));
      return std::array<int, 3>{bytes[0], bytes[1], bytes[2]};
    };
    for (int axis = 0; axis < 3; ++axis) {
      const auto seen = at(1.4 * radius * Vector3::Unit(axis));
      const auto most = std::max_element(seen.begin(), seen.end());
      EXPECT_EQ(most - seen.begin(), axis) << turn;
      for (int other = 0; other < 3; ++other) {
        if (other == axis) continue;
        EXPECT_GT(*most, seen[static_cast<std::size_t>(other)] + 20) << axis << " " << turn;
      }
    }
    const auto middle = at(radius * Vector3::Ones().normalized());
    EXPECT_LT(*std::max_element(middle.begin(), middle.end()),
              *std::min_element(middle.begin(), middle.end()) + 6);
  }
}

}  // namespace
}  // namespace palpate::render
