// What hides what, and what shades what, beside rays cast through the same scene one by one.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/picture_scene_for_tests.h"

namespace palpate {
namespace {

// Points of the lamp's disc as seen from `at`, evenly: other points than the picture's sixteen.
std::vector<Vector3> lamp_points(const device::RoomLight& light, const Vector3& at) {
  const Vector3 z = (light.lamp - at).normalized(), x = z.unitOrthogonal(), y = z.cross(x);
  std::vector<Vector3> points;
  for (int ring = 0; ring < 8; ++ring)
    for (int i = 0; i < 32; ++i) {
      const double r = light.lamp_radius * std::sqrt((ring + 0.5) / 8),
                   a = (i + 0.5 * (ring % 2)) * std::numbers::pi / 16;
      points.push_back(light.lamp + r * (std::cos(a) * x + std::sin(a) * y));
    }
  return points;
}

bool ball_between(const Vector3& from, const Vector3& to, const Vector3& centre, double radius) {
  const Vector3 d = (to - from).normalized(), c = centre - from;
  const double along = c.dot(d);
  return along > 0 && (c - along * d).norm() < radius;
}

TEST(Occlusion, IsThatOfRaysPixelByPixel) {
  const render::RealScene real = real_scene(true);
  const Triangles arm = triangles_of(*real.arm, real.arm_base_below);
  const Vector3 tip = (real.arm->X_world_base * device::phantom_tip(real.arm->theta)).m,
                eye = kTestEye.translation;
  const scene::TriangleMesh ball = scene::sphere_mesh(0.020, 24, 48),
                            bat = scene::disc_mesh(0.075, 0.010, 48);
  // The bat behind the forearm, the ball behind the bat but for a rim, both as the eye sees it.
  const Vector3 away = (tip - eye).normalized();
  scene::DrawItem bat_item = item_at(bat, tip + Vector3(0.0, 0.05, 0.0) + 0.10 * away, kGreen);
  bat_item.rotation = rotation_between(Vector3::UnitY(), -away);
  const scene::DrawItem ball_item = item_at(ball, bat_item.position + 0.08 * away + Vector3(-0.075, 0.02, 0));
  const std::vector<scene::DrawItem> items{bat_item, ball_item};
  render::Compositor compositor(render::CompositorSettings{.shadows = false});
  const device::CameraImage image = even_image(kTestCamera, 90);
  std::vector<std::uint8_t> rgb;
  compositor.draw(image, kTestCamera, kTestEye, items, real, rgb);

  const Triangles ball_shape = triangles_of(ball, ball_item.rotation, ball_item.position);
  const Triangles bat_shape = triangles_of(bat, bat_item.rotation, bat_item.position);
  enum Seen { image_seen, arm_seen, bat_seen, ball_seen, bat_hides_ball, arm_hides_bat };
  const auto look = [&](double u, double v) {
    const Vector3 d = ray_of(kTestCamera, kTestEye, u, v);
    const double a = nearest_hit(arm, eye, d), b = nearest_hit(bat_shape, eye, d),
                 c = nearest_hit(ball_shape, eye, d);
    if (std::isinf(std::min({a, b, c}))) return image_seen;
    if (a < std::min(b, c)) return std::isinf(b) ? arm_seen : arm_hides_bat;
    if (b < c) return std::isinf(c) ? bat_seen : bat_hides_ball;
    return ball_seen;
  };
  std::array<int, 6> count{};
  const device::Pixel middle =
      kTestCamera.project_undistorted((kTestEye.inverse() * Point<World>{bat_item.position}).m);
  for (int v = static_cast<int>(middle.y()) - 60; v < middle.y() + 60; v += 2)
    for (int u = static_cast<int>(middle.x()) - 70; u < middle.x() + 70; u += 2) {
      const Seen seen = look(u, v);
      // Within 0.7 px of an edge a pixel may hold both.
      if (look(u - 0.7, v) != seen || look(u + 0.7, v) != seen || look(u, v - 0.7) != seen ||
          look(u, v + 0.7) != seen)
        continue;
      ++count[seen];
      const std::uint8_t* p = pixel_of(rgb, kTestCamera, u, v);
      const bool untouched = p[0] == 90 && p[1] == 90 && p[2] == 90;
      const bool green = p[1] > p[0] + 20, orange = p[0] > p[2] + 40;
      switch (seen) {
        case image_seen:
        case arm_seen:
        case arm_hides_bat:
          EXPECT_TRUE(untouched) << u << " " << v;
          break;
        case bat_seen:
        case bat_hides_ball:
          EXPECT_TRUE(green) << u << " " << v;
          break;
        case ball_seen:
          EXPECT_TRUE(orange) << u << " " << v;
          break;
      }
    }
  for (const Seen each : {image_seen, bat_seen, ball_seen, bat_hides_ball, arm_hides_bat})
    EXPECT_GT(count[each], 15) << each;  // all of it happens in this picture
}

TEST(Occlusion, RegisteredBodiesHideVirtualThingsToo) {
  const scene::TriangleMesh block = scene::box_mesh({-0.05, 0.0, -0.05}, {0.05, 0.1, 0.05}),
                            ball = scene::sphere_mesh(0.020);
  render::RealScene real = real_scene(false);
  real.bodies.push_back({&block, Quaternion::Identity(), {0.0, kTableHeight, 1.4}});
  render::Compositor compositor(render::CompositorSettings{.shadows = false});
  const device::CameraImage image = even_image(kTestCamera, 90);
  std::vector<std::uint8_t> rgb;
  const Vector3 away = (Vector3(0.0, kTableHeight + 0.05, 1.4) - kTestEye.translation).normalized();
  const scene::DrawItem behind = item_at(ball, Vector3(0.0, kTableHeight + 0.05, 1.4) + 0.10 * away);
  const scene::DrawItem before = item_at(ball, Vector3(0.0, kTableHeight + 0.05, 1.4) - 0.10 * away);
  compositor.draw(image, kTestCamera, kTestEye, {&behind, 1}, real, rgb);
  EXPECT_EQ(rgb, image.rgb);
  compositor.draw(image, kTestCamera, kTestEye, {&before, 1}, real, rgb);
  EXPECT_NE(rgb, image.rgb);
}

// Where shadow begins and ends on each row of the picture, between pixels.
struct Crossing {
  double first = -1, last = -1;
};
Crossing crossing(const std::vector<double>& row, const std::vector<bool>& ball, double threshold) {
  Crossing c;
  for (std::size_t u = 2; u + 1 < row.size(); ++u) {
    if (ball[u - 2] || ball[u - 1] || ball[u] || ball[u + 1])
      continue;  // edges of the ball are none of a shadow
    if ((row[u - 1] > threshold) == (row[u] > threshold)) continue;
    const double at = static_cast<double>(u) - 1 + (threshold - row[u - 1]) / (row[u] - row[u - 1]);
    if (row[u] <= threshold && c.first < 0) c.first = at;
    if (row[u] > threshold) c.last = at;
  }
  return c;
}

double distance_to(const std::vector<device::Pixel>& line, const device::Pixel& p) {
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < line.size(); ++i) {
    const device::Pixel side = line[i] - line[i - 1];
    const double share = std::clamp((p - line[i - 1]).dot(side) / side.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - line[i - 1] - share * side).norm());
  }
  return nearest;
}

// Ball on the table. Expected: every pixel's ray on the table, its lamp points past an exact ball.
TEST(Shadows, MeetTheBallAtItsContactWithinAPixel) {
  render::CompositorSettings settings;
  render::Compositor compositor(settings);
  const double radius = 0.020, level = 200;
  const scene::TriangleMesh mesh = scene::sphere_mesh(radius, 48, 96);
  const Vector3 centre(-0.05, kTableHeight + radius, 1.55), eye = kTestEye.translation;
  const scene::DrawItem item = sphere_at(mesh, radius, centre);
  std::vector<std::uint8_t> rgb;
  compositor.draw(even_image(kTestCamera, static_cast<std::uint8_t>(level)), kTestCamera, kTestEye,
                  {&item, 1}, real_scene(false), rgb);

  const device::Pixel contact = kTestCamera.project_undistorted(
      (kTestEye.inverse() * Point<World>{centre - radius * Vector3::UnitY()}).m);
  const int u0 = static_cast<int>(contact.x()) - 70, u1 = u0 + 140;
  int rows = 0, meeting = 0;
  std::array<std::vector<device::Pixel>, 2> expected_edge, drawn_edge;  // left and right, from row to row
  for (int v = static_cast<int>(contact.y()) - 30; v < contact.y() + 30; ++v) {
    std::vector<double> expected, drawn;
    std::vector<bool> ball;
    for (int u = u0; u < u1; ++u) {
      const Vector3 d = ray_of(kTestCamera, kTestEye, u, v);
      const Vector3 at = eye + d * ((kTableHeight - eye.y()) / d.y());
      ball.push_back(ball_between(eye, at, centre, radius));
      double hidden = 0.0;
      const auto points = lamp_points(settings.light, at);
      for (const Vector3& lamp : points) hidden += ball_between(at, lamp, centre, radius) ? 1.0 : 0.0;
      hidden /= static_cast<double>(points.size());
      const Vector3 to = centre - at;
      const double open = 1.0 - to.y() * radius * radius / std::pow(to.norm(), 3);
      const double facing = (settings.light.lamp - at).normalized().y();
      const double before = settings.light.ambient + settings.light.key * facing;
      const double after = settings.light.ambient * open + settings.light.key * (1.0 - hidden) * facing;
      expected.push_back(ball.back() ? 0.0 : level * std::sqrt(after / before));
      const std::uint8_t* p = pixel_of(rgb, kTestCamera, u, v);
      drawn.push_back(p[0] > p[2] + 12 ? 0.0 : p[0]);  // the ball is orange, the table grey
    }
    const double threshold = 0.75 * level;
    const Crossing e = crossing(expected, ball, threshold), s = crossing(drawn, ball, threshold);
    for (const std::size_t side : {0u, 1u}) {
      const double one = side == 0 ? e.first : e.last, other = side == 0 ? s.first : s.last;
      if (one < 0 || other < 0) continue;
      expected_edge[side].emplace_back(one, v);
      drawn_edge[side].emplace_back(other, v);
    }
    if (e.first < 0) continue;
    ASSERT_GE(s.first, 0) << v;
    ++rows;
    // The lamp stands to the right. On the rows on which the shadow reaches the ball nothing between them is
    // lit.
    const auto begin = static_cast<std::size_t>(std::find(ball.begin(), ball.end(), true) - ball.begin());
    if (begin == ball.size() || expected[begin - 1] > threshold) continue;
    int lit = 0;
    for (auto i = static_cast<std::size_t>(s.first) + 1; i < begin; ++i) lit += drawn[i] > threshold ? 1 : 0;
    EXPECT_LE(lit, 1) << v;
    ++meeting;
  }
  EXPECT_GT(rows, 8);
  EXPECT_GT(meeting, 4);
  double worst = 0.0;
  for (const std::size_t side : {0u, 1u})
    for (const device::Pixel& p : drawn_edge[side])
      worst = std::max(worst, distance_to(expected_edge[side], p));
  EXPECT_LT(worst, 1.0);
  RecordProperty("shadow_edge_worst_px", std::to_string(worst));
}

TEST(Shadows, OfTheRealArmFallOnVirtualThings) {
  const render::RealScene real = real_scene(true);
  const Triangles arm = triangles_of(*real.arm, real.arm_base_below);
  const render::CompositorSettings settings;
  render::Compositor compositor(settings);
  const scene::TriangleMesh sheet = scene::disc_mesh(0.06, 0.004, 48);  // level, below the forearm
  const Vector3 tip = (real.arm->X_world_base * device::phantom_tip(real.arm->theta)).m;
  const Vector3 base = real.arm->X_world_base.translation;
  const Vector3 over = 0.5 * (tip + base);
  const Vector3 place = over + 0.10 * (over - settings.light.lamp).normalized();
  scene::DrawItem item = item_at(sheet, place, kGreen);
  std::vector<std::uint8_t> with, without;
  const device::CameraImage image = even_image(kTestCamera, 90);
  render::RealScene bare = real_scene(false);
  compositor.draw(image, kTestCamera, kTestEye, {&item, 1}, real, with);
  compositor.draw(image, kTestCamera, kTestEye, {&item, 1}, bare, without);
  int dark = 0, lit = 0, wrong = 0;
  for (double x = -0.05; x <= 0.05; x += 0.005)
    for (double z = -0.05; z <= 0.05; z += 0.005) {
      if (std::hypot(x, z) > 0.052) continue;
      const Vector3 p = place + Vector3(x, 0.002, z);
      const Vector3 sight = p - kTestEye.translation;
      if (nearest_hit(arm, kTestEye.translation, sight) < 1.0) continue;  // the arm is in the way
      double hidden = 0.0;
      const auto points = lamp_points(settings.light, p);
      for (std::size_t i = 0; i < points.size(); i += 8)
        hidden += nearest_hit(arm, p, points[i] - p) < 1.0 ? 8.0 / static_cast<double>(points.size()) : 0.0;
      const device::Pixel pixel = kTestCamera.project_undistorted((kTestEye.inverse() * Point<World>{p}).m);
      const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
      const double ratio =
          static_cast<double>(pixel_of(with, kTestCamera, u, v)[1]) / pixel_of(without, kTestCamera, u, v)[1];
      // In the map a shadow has one width of edge; where the lamp is wholly seen or hidden it must agree.
      if (hidden == 0.0) wrong += ratio < 0.9 ? 1 : 0, ++lit;
      if (hidden > 0.999) wrong += ratio > 0.75 ? 1 : 0, ++dark;
    }
  EXPECT_GT(lit, 20);
  EXPECT_GT(dark, 5);
  EXPECT_LE(wrong, (lit + dark) / 20);  // edges narrower than the lamp's penumbra
}

TEST(Shadows, OfVirtualThingsFallOnTheRealArm) {
  const render::RealScene real = real_scene(true);
  const render::CompositorSettings settings;
  render::Compositor compositor(settings);
  const scene::TriangleMesh sheet = scene::disc_mesh(0.05, 0.004, 48);
  const Vector3 tip = (real.arm->X_world_base * device::phantom_tip(real.arm->theta)).m;
  const Vector3 over = 0.5 * (tip + real.arm->X_world_base.translation);
  scene::DrawItem item = item_at(sheet, over + 0.25 * (settings.light.lamp - over).normalized(), kGreen);
  const device::CameraImage image = even_image(kTestCamera, 90);
  std::vector<std::uint8_t> rgb;
  compositor.draw(image, kTestCamera, kTestEye, {&item, 1}, real, rgb);
  const Triangles arm = triangles_of(*real.arm, real.arm_base_below);
  const Triangles sheet_shape = triangles_of(sheet, item.rotation, item.position);
  int darkened = 0, seen = 0;
  for (int v = 100; v < 470; v += 3)
    for (int u = 150; u < 600; u += 3) {
      const Vector3 d = ray_of(kTestCamera, kTestEye, u, v);
      const double t = nearest_hit(arm, kTestEye.translation, d);
      if (std::isinf(t) || nearest_hit(sheet_shape, kTestEye.translation, d) < t) continue;
      const Vector3 p = kTestEye.translation + t * d, to_lamp = settings.light.lamp - p;
      if (std::isinf(nearest_hit(sheet_shape, p, to_lamp))) continue;
      if (nearest_hit(arm, p + 2e-3 * to_lamp.normalized(), to_lamp) < 1.0) continue;  // dark already
      ++seen;
      darkened += pixel_of(rgb, kTestCamera, u, v)[1] < 88 ? 1 : 0;
    }
  EXPECT_GT(seen, 20);
  EXPECT_GT(darkened, seen / 2);  // what faces away from the lamp has no light to lose
}

TEST(Shadows, FallNoDarkerWhereARealOneLiesAlready) {
  render::RealScene real = real_scene(false);
  const scene::TriangleMesh plate = scene::box_mesh({-0.15, 0.0, -0.15}, {0.15, 0.004, 0.15}),
                            ball = scene::sphere_mesh(0.020);
  const render::CompositorSettings settings;
  // The plate between lamp and table, the ball close to the table in the middle of its shadow.
  const Vector3 foot(0.0, kTableHeight, 1.35), up = (settings.light.lamp - foot).normalized();
  const scene::DrawItem item = sphere_at(ball, 0.020, foot + 0.10 * up);
  const device::CameraImage image = even_image(kTestCamera, 120);
  const device::Pixel at = kTestCamera.project_undistorted((kTestEye.inverse() * Point<World>{foot}).m);
  const int u = static_cast<int>(std::lround(at.x())), v = static_cast<int>(std::lround(at.y()));
  render::Compositor compositor(settings);
  std::vector<std::uint8_t> rgb;
  compositor.draw(image, kTestCamera, kTestEye, {&item, 1}, real, rgb);
  EXPECT_LT(pixel_of(rgb, kTestCamera, u, v)[1], 100);
  real.bodies.push_back({&plate, Quaternion::Identity(), foot + 0.35 * up});
  compositor.draw(image, kTestCamera, kTestEye, {&item, 1}, real, rgb);
  EXPECT_GE(pixel_of(rgb, kTestCamera, u, v)[1], 118);
}

// An edge through the middle of a pixel, over black: half of the thing's light is left in it, and the byte
// says so in the camera's own encoding.
TEST(Encoding, EdgesAreMixedAsLight) {
  const auto root = [](double x) { return std::sqrt(x); };
  const auto srgb = [](double x) { return x < 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055; };
  const auto srgb_back = [](double y) {
    return y < 0.04045 ? y / 12.92 : std::pow((y + 0.055) / 1.055, 2.4);
  };
  const device::CameraModel camera{64, 64, 100, 100, 31.5, 31.5, {}};
  const scene::TriangleMesh sheet = scene::rectangle_mesh({0, -0.3, 0}, {0.3, 0, 0}, {0, 0.6, 0});
  scene::DrawItem item = item_at(sheet, {0.005, 0, 1.0}, kGreen);  // its edge at u = 32
  for (const device::Encoding encoding :
       {device::Encoding::root, device::Encoding::srgb, device::Encoding::linear}) {
    render::CompositorSettings settings{.shadows = false};
    settings.encoding = encoding;
    render::Compositor compositor(settings);
    std::vector<std::uint8_t> rgb;
    compositor.draw(even_image(camera, 0), camera, {}, {&item, 1}, {}, rgb);
    const double edge = pixel_of(rgb, camera, 32, 32)[1] / 255.0,
                 inside = pixel_of(rgb, camera, 33, 32)[1] / 255.0;
    ASSERT_GT(inside, 0.2);
    ASSERT_EQ(pixel_of(rgb, camera, 31, 32)[1], 0);
    const double expected = encoding == device::Encoding::root   ? root(0.5 * inside * inside)
                            : encoding == device::Encoding::srgb ? srgb(0.5 * srgb_back(inside))
                                                                 : 0.5 * inside;
    EXPECT_NEAR(edge, expected, 1.5 / 255);  // rounded twice
  }
}

TEST(Encoding, LeavesTheImageAsItIsWhereNothingVirtualLies) {
  for (const device::Encoding encoding :
       {device::Encoding::root, device::Encoding::srgb, device::Encoding::linear}) {
    render::CompositorSettings settings;
    settings.encoding = encoding;
    render::Compositor compositor(settings);
    device::CameraImage image = even_image(kTestCamera, 0);
    for (std::size_t i = 0; i < image.rgb.size(); ++i) image.rgb[i] = static_cast<std::uint8_t>(i / 3 % 256);
    const scene::TriangleMesh ball = scene::sphere_mesh(0.020);
    const scene::DrawItem under =
        item_at(ball, {0.1, -1.60, 1.4});  // hidden by the table, but its box is drawn
    std::vector<std::uint8_t> rgb;
    compositor.draw(image, kTestCamera, kTestEye, {&under, 1}, real_scene(false), rgb);
    EXPECT_EQ(rgb, image.rgb);
  }
}

}  // namespace
}  // namespace palpate
