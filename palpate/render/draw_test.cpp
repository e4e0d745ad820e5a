#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "palpate/render/arm_shape.h"
#include "palpate/render/context.h"
#include "palpate/render/mesh_buffer.h"
#include "palpate/render/planar_shadow.h"
#include "palpate/render/projection.h"
#include "palpate/render/shadow_texels_for_tests.h"

namespace palpate::render {
namespace {

TEST(Context, IsSharedWithinAThreadAndNamesItsRenderer) {
  const auto a = Context::required();
  const auto b = Context::required();
  EXPECT_EQ(a, b);
  EXPECT_FALSE(a->renderer().empty());
  EXPECT_TRUE(a->make_current());
}

TEST(Program, SaysWhatIsWrongWithAShader) {
  const auto context = Context::required();
  try {
    Program bad("bad one", kFullScreen, "out vec4 colour; void main() { colour = nonsense; }");
    FAIL() << "compiled";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("bad one"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("nonsense"), std::string::npos);
  }
}

TEST(Target, ReadsRowsFromTheTopWithoutFlips) {
  const auto context = Context::required();
  FullScreen screen;
  Program steps("steps", kFullScreen,
                "out vec4 colour; void main() { colour = vec4(floor(gl_FragCoord.xy), 0, 255) / 255.0; }");
  Target target(5, 3, Format::rgb8, false);  // an odd width: rows are packed, not padded
  target.bind();
  steps.use();
  screen.draw();
  std::vector<std::uint8_t> rgb;
  target.read_rgb(rgb);
  ASSERT_EQ(rgb.size(), 45u);
  for (int v = 0; v < 3; ++v) {
    for (int u = 0; u < 5; ++u) {
      EXPECT_EQ(rgb[static_cast<std::size_t>(3 * (5 * v + u))], u);
      EXPECT_EQ(rgb[static_cast<std::size_t>(3 * (5 * v + u) + 1)], v);
    }
  }
}

TEST(Projection, PutsPointsHalfAPixelFromTheCameraModelsNumbers) {
  const device::CameraModel camera{640, 480, 560, 561.5, 318.7, 242.1, {-0.28, 0.09, 0.001, -0.0005, 0}};
  const Matrix4f m = projection_matrix(camera, 0.05, 10.0);
  for (const Vector3& p : {Vector3(0.1, -0.2, 1.0), Vector3(-0.4, 0.3, 0.9), Vector3(0, 0, 5)}) {
    const Vector4f clip = m * Vector4f(p.cast<float>().homogeneous());
    const device::Pixel expected = camera.project_undistorted(p);
    // Single precision: 1e-7 of 640 px.
    EXPECT_NEAR((clip.x() / clip.w() + 1.0) * 320.0, expected.x() + 0.5, 2e-4);
    EXPECT_NEAR((clip.y() / clip.w() + 1.0) * 240.0, expected.y() + 0.5, 2e-4);
  }
  const Vector4f near = m * Vector4f(0, 0, 0.05f, 1), far = m * Vector4f(0, 0, 10, 1);
  EXPECT_NEAR(near.z() / near.w(), -1.0, 1e-4);
  EXPECT_NEAR(far.z() / far.w(), 1.0, 1e-4);
}

TEST(Shaded, KeepsEdgesOfABoxAndSmoothsASphere) {
  const ShadedMesh box = shaded(scene::box_mesh({-1, -1, -1}, {1, 1, 1}));
  EXPECT_EQ(box.vertices.size(), 24u);  // three normals at each of eight corners
  const ShadedMesh ball = shaded(scene::sphere_mesh(0.5, 24, 48));
  for (const ShadedVertex& vertex : ball.vertices) {
    // Facets of 7.5 deg: their average leaves the radius by far less than a facet.
    EXPECT_GT(Vector3f(vertex.normal).dot(Vector3f(vertex.position).normalized()), std::cos(0.03f));
  }
}

TEST(ArmShape, LinksMeetAtElbowAndTip) {
  const device::PhantomLengths lengths{0.21, 0.20};
  const Vector3 theta(0.3, 0.5, -0.2), gimbal(0.1, -0.4, 0.7);
  const auto poses = arm_part_poses(lengths, theta, gimbal, {});
  const auto at = [&](ArmFrame frame) { return poses[static_cast<std::size_t>(frame)]; };
  const Vector3 elbow =
      at(ArmFrame::upper).rotation * Vector3(0, 0, lengths.l1) + at(ArmFrame::upper).translation;
  EXPECT_NEAR((elbow - at(ArmFrame::forearm).translation).norm(), 0.0, 1e-12);
  const Vector3 tip = at(ArmFrame::forearm).rotation * Vector3(0, -lengths.l2, 0) + elbow;
  EXPECT_NEAR((tip - device::phantom_tip(theta, lengths).m).norm(), 0.0, 1e-12);
  EXPECT_NEAR((tip - at(ArmFrame::stylus).translation).norm(), 0.0, 1e-12);
}

TEST(PlanarShadow, LiesWhereTheLampThrowsIt) {
  const auto context = Context::required();
  FullScreen screen;
  PlanarShadow shadow(128);
  const MeshBuffer ball(scene::sphere_mesh(0.02));
  device::RoomLight light;
  light.lamp = {0.3, 1.5, 0.2};
  light.lamp_radius = 0.05;
  const ShadowReceiver table{{-0.5, 0.0, 0.5}, Vector3::UnitX(), -Vector3::UnitZ(), 1.0, 1.0};
  const Vector3 place(0.05, 0.15, -0.1);
  ShadowCaster caster{&ball};
  caster.X_world_mesh.topRightCorner<3, 1>() = place.cast<float>();
  ASSERT_TRUE(shadow.draw({&caster, 1}, table, light, screen));
  const auto rgb = texels_of(shadow, screen);
  double sum = 0, x = 0, y = 0, most = 0;
  for (int v = 0; v < 128; ++v) {
    for (int u = 0; u < 128; ++u) {
      const double dark = rgb[static_cast<std::size_t>(3 * (128 * v + u))] / 255.0;
      const double px = shadow.part()[0] + (u + 0.5) / 128.0 * shadow.part()[2];
      const double py = shadow.part()[1] + (v + 0.5) / 128.0 * shadow.part()[3];
      sum += dark, x += dark * px, y += dark * py;
      most = std::max(most, dark);
    }
  }
  const Vector3 foot = light.lamp + (place - light.lamp) * (light.lamp.y() / (light.lamp.y() - place.y()));
  // The sphere's shadow is a slightly lopsided ellipse; lamp sampled at 16 points: a millimetre.
  EXPECT_NEAR(x / sum, foot.x() + 0.5, 1.5e-3);
  EXPECT_NEAR(y / sum, 0.5 - foot.z(), 1.5e-3);
  EXPECT_GT(most, 0.99);  // the lamp is small enough to be hidden wholly in the middle
  caster.X_world_mesh.topRightCorner<3, 1>() = Vector3f(5, 0.15f, 5);
  EXPECT_FALSE(shadow.draw({&caster, 1}, table, light, screen));
}

}  // namespace
}  // namespace palpate::render
