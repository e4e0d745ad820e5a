#include "palpate/sim/camera_renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/random.h"
#include "palpate/draw/arm_body.h"
#include "palpate/draw/context.h"
#include "palpate/draw/planar_shadow.h"
#include "palpate/draw/projection.h"
#include "palpate/sim/camera_shaders.h"
#include "palpate/sim/lens_rays.h"
#include "palpate/sim/sensor_noise.h"

namespace palpate::sim {
namespace {

using draw::Program;
using draw::ShadowReceiver;

constexpr double kTableThickness = 0.024, kTableHeight = 0.74;  // m
constexpr double kLayerScale = 1.1;  // the arm is drawn this much finer than the camera sees, then bent
constexpr int kTile = 32;            // px, of the room's tiles
constexpr float kFalloff = 0.16f;    // light lost in the corners, per squared ray length

// Of each ArmLook: colour; how much it mirrors straight on, at the edge, the lamp; light of its own.
const std::vector<draw::Vector3f> kArmLooks = {
    {0.022f, 0.022f, 0.023f}, {0.04f, 0.30f, 0.10f}, {0, 0, 0},               // black
    {0.16f, 0.165f, 0.175f},  {0.45f, 0.40f, 0.75f}, {0, 0, 0},               // metal
    {0.055f, 0.057f, 0.062f}, {0.12f, 0.35f, 0.25f}, {0, 0, 0},               // dark
    {0.70f, 0.70f, 0.70f},    {0.02f, 0.05f, 0.05f}, {0, 0, 0},               // bright
    {0.10f, 0.01f, 0.01f},    {0.02f, 0.00f, 0.50f}, {0.55f, 0.05f, 0.04f}};  // red

bool same(const CameraModel& a, const CameraModel& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx &&
         a.cy == b.cy && a.distortion == b.distortion;
}

ShadowReceiver rectangle(const std::array<Vector3, 4>& corners) {
  const Vector3 x = corners[1] - corners[0], y = corners[3] - corners[0];
  return {corners[0], x.normalized(), y.normalized(), x.norm(), y.norm()};
}
Vector3 normal(const ShadowReceiver& r) { return r.side_x.cross(r.side_y); }
draw::Vector4f plane(const ShadowReceiver& r) {
  const Vector3 n = normal(r);
  return Eigen::Vector4d(n.x(), n.y(), n.z(), -n.dot(r.corner)).cast<float>();
}

// Smooth repeating noise: four octaves of interpolated random values.
std::vector<std::uint8_t> grain(int size) {
  std::vector<double> sum(static_cast<std::size_t>(size * size), 0.5);
  Random random(1, "sim/grain");
  double weight = 0.22;
  for (int cells = 8; cells <= 128; cells *= 2, weight *= 0.68) {
    std::vector<double> value(static_cast<std::size_t>(cells * cells));
    for (double& v : value) v = random.uniform(-1.0, 1.0);
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        const double gx = static_cast<double>(x) * cells / size, gy = static_cast<double>(y) * cells / size;
        const int ix = static_cast<int>(gx), iy = static_cast<int>(gy);
        const auto smooth = [](double t) { return t * t * (3.0 - 2.0 * t); };
        const double a = smooth(gx - ix), b = smooth(gy - iy);
        const auto at = [&](int i, int j) {
          return value[static_cast<std::size_t>(((iy + j) % cells) * cells + (ix + i) % cells)];
        };
        sum[static_cast<std::size_t>(y * size + x)] +=
            weight *
            ((1 - b) * ((1 - a) * at(0, 0) + a * at(1, 0)) + b * ((1 - a) * at(0, 1) + a * at(1, 1)));
      }
    }
  }
  std::vector<std::uint8_t> bytes;
  bytes.reserve(sum.size());
  for (const double v : sum)
    bytes.push_back(static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(v, 0.0, 1.0))));
  return bytes;
}

}  // namespace

struct CameraRenderer::Impl {
  std::shared_ptr<draw::Context> context = draw::Context::required();
  draw::RoomLight light;
  draw::FullScreen screen;
  Program table{"sim/table", draw::kFullScreen, table_shader()},
      side{"sim/side", draw::kFullScreen, side_shader()}, wall{"sim/wall", draw::kFullScreen, wall_shader()},
      room{"sim/room", kTileVertex, room_shader()}, leg{"sim/leg", draw::kFullScreen, leg_shader()},
      floor{"sim/floor", draw::kFullScreen, floor_shader()}, dot{"sim/dot", draw::kFullScreen, dot_shader()},
      board{"sim/board", draw::kFullScreen, board_shader()},
      layer{"sim/layer", draw::kFullScreen, layer_shader()},
      arm{"sim/arm", kArmVertex, std::string(draw::kLightGlsl) + kArmFragment};
  draw::PlanarShadow table_shadow{160}, wall_shadow{96};
  draw::Texture grain_texture{256, 256, draw::Format::r8, draw::Filter::linear_repeat};

  CameraModel lens;  // for which the next four were made
  draw::Texture rays;
  draw::Target picture, arm_layer;
  Eigen::Vector2d ray_low, ray_high;
  CameraModel layer_camera;

  PhantomLengths arm_lengths;
  std::vector<Vector3> arm_leds;
  double arm_foot = 0.0;
  std::unique_ptr<draw::ArmBody> arm_body, arm_shadow_body;
  std::array<Vector3, 4> floor_table{};
  draw::Target boards{512, 512, draw::Format::rgb8, false};
  std::vector<Eigen::Vector2f> ray_list;
  draw::MeshBuffer tiles;
  draw::ShadedMesh tile_quads;
  SensorNoise noise{0.0};

  Impl() { grain_texture.upload(grain(256).data()); }

  void prepare_lens(const CameraModel& model) {
    if (rays && same(model, lens)) return;
    lens = model;
    const LensRays all = lens_rays(model);
    rays = draw::Texture(model.width, model.height, draw::Format::rg32f, draw::Filter::nearest);
    rays.upload(all.ray.data());
    ray_list = all.ray;
    picture = draw::Target(model.width, model.height, draw::Format::rgb8, false);
    ray_low = all.low;
    ray_high = all.high;
    layer_camera = {};
    layer_camera.fx = kLayerScale * model.fx;
    layer_camera.fy = kLayerScale * model.fy;
    layer_camera.cx = 2.0 - layer_camera.fx * ray_low.x();
    layer_camera.cy = 2.0 - layer_camera.fy * ray_low.y();
    layer_camera.width = static_cast<int>(std::ceil(layer_camera.fx * (ray_high.x() - ray_low.x()))) + 4;
    layer_camera.height = static_cast<int>(std::ceil(layer_camera.fy * (ray_high.y() - ray_low.y()))) + 4;
    arm_layer = draw::Target(layer_camera.width, layer_camera.height, draw::Format::rgba8, true, 4);
  }

  void prepare_bodies(const TrueView& view, const ShadowReceiver& top) {
    // The arm stands on the table.
    const double foot = std::max(0.0, (view.X_world_base.translation - top.corner).dot(normal(top)));
    if (!arm_body || view.lengths.l1 != arm_lengths.l1 || view.lengths.l2 != arm_lengths.l2 ||
        view.marker_leds != arm_leds || std::abs(foot - arm_foot) > 1e-9) {
      arm_lengths = view.lengths;
      arm_leds = view.marker_leds;
      arm_foot = foot;
      arm_body = std::make_unique<draw::ArmBody>(
          arm_lengths, draw::ArmShapeSettings{.base_below = foot, .leds = arm_leds, .segments = 24});
      arm_shadow_body = std::make_unique<draw::ArmBody>(
          arm_lengths, draw::ArmShapeSettings{.base_below = foot, .leds = arm_leds, .segments = 8});
    }
  }

  static bool scissor(const std::array<int, 4>& box) {
    if (box[2] <= 0 || box[3] <= 0) return false;
    glEnable(GL_SCISSOR_TEST);
    glScissor(box[0], box[1], box[2], box[3]);
    return true;
  }

  void common(Program& program) {
    program.use().set("rays", 0).set("grain", 1).set("shadow", 2).set("falloff", kFalloff);
    draw::set_light(program, light);
  }

  // Sets up a flat thing's uniforms and the part of the picture it can touch; false when it cannot be seen.
  bool flat(Program& program, const TrueView& view, const ShadowReceiver& r, bool two_sided = false) {
    const Pose<CameraOptical, World> X = view.X_world_camera.inverse();
    const Vector3 c = (X * Point<World>{r.corner}).m, x = X.rotation * r.side_x, y = X.rotation * r.side_y;
    if (!two_sided && x.cross(y).dot(c) >= 0.0) return false;  // seen from behind
    const auto box =
        pixel_box(view.lens, {c, c + r.width * x, c + r.width * x + r.height * y, c + r.height * y});
    if (!scissor(box)) return false;
    Matrix3 plane_to_ray;
    plane_to_ray << x, y, c;
    common(program);
    program.set("to_plane", draw::Matrix3f(plane_to_ray.inverse().cast<float>()))
        .set("size", draw::Vector2f(static_cast<float>(r.width), static_cast<float>(r.height)))
        .set("corner", draw::Vector3f(r.corner.cast<float>()))
        .set("side_x", draw::Vector3f(r.side_x.cast<float>()))
        .set("side_y", draw::Vector3f(r.side_y.cast<float>()))
        .set("eye", draw::Vector3f(view.X_world_camera.translation.cast<float>()))
        .set("shadow_part", draw::Vector4f(draw::Vector4f::Zero()));
    return true;
  }

  void use_shadow(Program& program, bool any, const draw::PlanarShadow& shadow) {
    if (!any) return;
    shadow.texture().bind(2);
    program.set("shadow_part", shadow.part());
  }

  struct Room {
    Vector3 low, high;
  };
  static Room room_round(const ShadowReceiver& top, const ShadowReceiver& back) {
    const double floor_y = top.corner.y() - kTableHeight;
    const double behind = std::min(top.corner.z(), back.corner.z()) - 0.9;
    return {{-2.1, floor_y, behind}, {2.1, floor_y + 2.7, behind + 5.0}};
  }

  // The floor with the table's shadow, once for each place of the table.
  void prepare_floor(const TrueView& view, const ShadowReceiver& top, const Room& box) {
    if (view.table == floor_table) return;
    floor_table = view.table;
    boards.bind();
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_BLEND);
    grain_texture.bind(1);
    common(floor);
    floor.set("room_low", draw::Vector3f(box.low.cast<float>()))
        .set("room_high", draw::Vector3f(box.high.cast<float>()))
        .set("table_corner", draw::Vector3f(top.corner.cast<float>()))
        .set("table_x", draw::Vector3f(top.side_x.cast<float>()))
        .set("table_y", draw::Vector3f(top.side_y.cast<float>()))
        .set("table_size", draw::Vector2f(static_cast<float>(top.width), static_cast<float>(top.height)))
        .set("texels",
             draw::Vector2f(static_cast<float>(boards.width()), static_cast<float>(boards.height())));
    screen.draw();
  }

  // Tiles of the picture that are not wholly covered by one of the rectangles.
  void uncovered_tiles(const TrueView& view, std::initializer_list<const ShadowReceiver*> covers) {
    std::vector<Eigen::Matrix3d> to_plane;
    std::vector<Eigen::Vector2d> size;
    const Pose<CameraOptical, World> X = view.X_world_camera.inverse();
    for (const ShadowReceiver* r : covers) {
      const Vector3 c = (X * Point<World>{r->corner}).m, x = X.rotation * r->side_x,
                    y = X.rotation * r->side_y;
      if (x.cross(y).dot(c) >= 0.0) continue;  // seen from behind: not drawn
      Matrix3 m;
      m << x, y, c;
      to_plane.push_back(m.inverse());
      size.emplace_back(r->width, r->height);
    }
    const int w = view.lens.width, h = view.lens.height;
    const auto covered = [&](int u, int v, std::size_t i) {
      const Eigen::Vector2f ray =
          ray_list[static_cast<std::size_t>(v) * static_cast<std::size_t>(w) + static_cast<std::size_t>(u)];
      const Vector3 p = to_plane[i] * Vector3(ray.x(), ray.y(), 1.0);
      constexpr double border = 0.01;  // m; more than a pixel's footprint and the bend of a tile's edge
      return p.z() > 0 && p.x() > border * p.z() && p.y() > border * p.z() &&
             p.x() < (size[i].x() - border) * p.z() && p.y() < (size[i].y() - border) * p.z();
    };
    tile_quads.vertices.clear();
    tile_quads.indices.clear();
    for (int v = 0; v < h; v += kTile) {
      for (int u = 0; u < w; u += kTile) {
        const int right = std::min(u + kTile, w), below = std::min(v + kTile, h);
        bool hidden = false;
        for (std::size_t i = 0; i < to_plane.size() && !hidden; ++i) {
          hidden = covered(u, v, i) && covered(right - 1, v, i) && covered(u, below - 1, i) &&
                   covered(right - 1, below - 1, i);
        }
        if (hidden) continue;
        const auto first = static_cast<std::uint32_t>(tile_quads.vertices.size());
        for (const auto& [x, y] :
             {std::pair{u, v}, std::pair{right, v}, std::pair{right, below}, std::pair{u, below}}) {
          tile_quads.vertices.push_back({{2.0f * static_cast<float>(x) / static_cast<float>(w) - 1.0f,
                                          2.0f * static_cast<float>(y) / static_cast<float>(h) - 1.0f, 0.0f},
                                         {0, 0, 0}});
        }
        for (const std::uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) tile_quads.indices.push_back(first + k);
      }
    }
    tiles.upload(tile_quads);
  }

  void draw_room(const TrueView& view, const ShadowReceiver& top, const ShadowReceiver& back,
                 const Room& box) {
    uncovered_tiles(view, {&top, &back});
    glDisable(GL_SCISSOR_TEST);
    common(room);
    boards.texture().bind(3);
    room.set("to_world", draw::Matrix3f(view.X_world_camera.matrix().cast<float>()))
        .set("boards", 3)
        .set("eye", draw::Vector3f(view.X_world_camera.translation.cast<float>()))
        .set("room_low", draw::Vector3f(box.low.cast<float>()))
        .set("room_high", draw::Vector3f(box.high.cast<float>()));
    tiles.draw();
  }

  // Far ones first; the table's top, drawn later, covers what it hides.
  void draw_legs(const TrueView& view, const ShadowReceiver& top) {
    constexpr double radius = 0.021;
    const Vector3 up = normal(top);
    for (const double b : {top.height - 0.06, 0.06}) {
      for (const double a : {0.045, top.width - 0.045}) {
        const Vector3 foot = top.corner + a * top.side_x + b * top.side_y - kTableHeight * up;
        const Vector3 x = up.cross(view.X_world_camera.translation - foot).normalized();
        if (flat(leg, view, {foot - radius * x, x, up, 2.0 * radius, kTableHeight})) screen.draw();
      }
    }
  }

  void draw_table_sides(const TrueView& view, const ShadowReceiver& top) {
    const Vector3 down = -kTableThickness * normal(top);
    for (std::size_t i = 0; i < 4; ++i) {
      const Vector3 a = view.table[i] + down, b = view.table[(i + 1) % 4] + down;
      const ShadowReceiver edge{a, (b - a).normalized(), normal(top), (b - a).norm(), kTableThickness};
      if (flat(side, view, edge)) screen.draw();
    }
  }

  void draw_dots(const TrueView& view, const ShadowReceiver& top, const ShadowReceiver& back, bool on_table,
                 bool on_wall) {
    for (const Dot& d : view.dots) {
      const Vector3 n = d.normal.normalized();
      const Vector3 x =
          std::abs(n.x()) < 0.9 ? Vector3(Vector3::UnitX() - n.x() * n).normalized() : n.unitOrthogonal();
      const Vector3 y = n.cross(x);
      const double half = 1.7 * d.diameter;
      if (!flat(dot, view, {d.centre - half * (x + y), x, y, 2.0 * half, 2.0 * half})) continue;
      dot.set("radius", static_cast<float>(0.5 * d.diameter));
      // Shadow of the surface it is glued to, in that surface's coordinates: shifted by the sticker's own
      // corner.
      const bool lies_on_table = n.dot(normal(top)) > n.dot(normal(back));
      const ShadowReceiver& under = lies_on_table ? top : back;
      const draw::PlanarShadow& shadow = lies_on_table ? table_shadow : wall_shadow;
      if ((lies_on_table ? on_table : on_wall) && x.dot(under.side_x) > 0.99 && y.dot(under.side_y) > 0.99) {
        shadow.texture().bind(2);
        draw::Vector4f part = shadow.part();
        const Vector3 shift = d.centre - half * (x + y) - under.corner;
        part.x() -= static_cast<float>(shift.dot(under.side_x));
        part.y() -= static_cast<float>(shift.dot(under.side_y));
        dot.set("shadow_part", part);
      }
      screen.draw();
    }
  }

  // The arm as triangles into a layer of its own, then through the lens. It stands before everything else.
  void draw_arm(const TrueView& view) {
    const Pose<CameraOptical, World> X = view.X_world_camera.inverse();
    Eigen::Vector2d low = ray_high, high = ray_low;
    bool everywhere = false;
    const auto take = [&](const Vector3& world) {
      const Vector3 p = (X * Point<World>{world}).m;
      if (p.z() < 0.06) everywhere = true;
      const Eigen::Vector2d n = p.head<2>() / std::max(p.z(), 0.06);
      low = low.cwiseMin(n);
      high = high.cwiseMax(n);
    };
    for (const auto& vertex : arm_body->vertices()) take(draw::Vector3f(vertex.position).cast<double>());
    if (everywhere) low = ray_low, high = ray_high;
    const int left = std::max(0, static_cast<int>(layer_camera.fx * low.x() + layer_camera.cx) - 3);
    const int above = std::max(0, static_cast<int>(layer_camera.fy * low.y() + layer_camera.cy) - 3);
    const int right =
        std::min(layer_camera.width, static_cast<int>(layer_camera.fx * high.x() + layer_camera.cx) + 4);
    const int below =
        std::min(layer_camera.height, static_cast<int>(layer_camera.fy * high.y() + layer_camera.cy) + 4);
    if (right <= left || below <= above) return;

    arm_layer.bind();
    scissor({left, above, right - left, below - above});
    glDisable(GL_BLEND);
    glEnable(GL_DEPTH_TEST);
    glClearColor(0, 0, 0, 0);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    arm.use()
        .set("to_clip", draw::Matrix4f(draw::projection_matrix(layer_camera, 0.05, 8.0) * draw::matrix4(X)))
        .set("eye", draw::Vector3f(view.X_world_camera.translation.cast<float>()));
    draw::set_light(arm, light);
    arm.set("looks", kArmLooks);
    glEnable(GL_CULL_FACE);
    glFrontFace(GL_CW);  // row 0 on top mirrors the window
    arm_body->mesh().draw();
    glFrontFace(GL_CCW);
    glDisable(GL_CULL_FACE);
    glDisable(GL_DEPTH_TEST);
    arm_layer.resolve(left, above, right - left, below - above);

    picture.bind();
    glDisable(GL_SCISSOR_TEST);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    common(layer);
    arm_layer.texture().bind(3);
    const double w = layer_camera.width, h = layer_camera.height;
    layer.set("layer", 3)
        .set("to_layer",
             draw::Vector4f(Eigen::Vector4d((layer_camera.cx + 0.5) / w, (layer_camera.cy + 0.5) / h,
                                            layer_camera.fx / w, layer_camera.fy / h)
                                .cast<float>()));
    layer.set("used", draw::Vector4f(Eigen::Vector4d((left + 0.5) / w, (above + 0.5) / h, (right - 0.5) / w,
                                                     (below - 0.5) / h)
                                         .cast<float>()));
    // Only where the layer holds something: its box, bent through the lens.
    const auto corner = [&](int x, int y) {
      return Vector3((x - layer_camera.cx) / layer_camera.fx, (y - layer_camera.cy) / layer_camera.fy, 1.0);
    };
    if (scissor(pixel_box(view.lens, {corner(left, above), corner(right, above), corner(right, below),
                                      corner(left, below)}))) {
      screen.draw();
    }
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  }

  void render(const TrueView& view, std::vector<std::uint8_t>& rgb) {
    if (!context->make_current())
      throw std::runtime_error("camera picture: asked for on another thread than its own");
    const ShadowReceiver top = rectangle(view.table), back = rectangle(view.wall);
    prepare_lens(view.lens);
    const Room box = room_round(top, back);
    prepare_floor(view, top, box);
    if (noise.sd() != view.noise_sd) noise = SensorNoise(view.noise_sd);
    prepare_bodies(view, top);
    const draw::ArmConfiguration configuration{view.X_world_base, view.lengths, view.theta, view.gimbal,
                                               view.X_tip_marker};
    arm_body->move(configuration);
    arm_shadow_body->move(configuration);
    const draw::ShadowCaster caster{&arm_shadow_body->mesh()};
    const bool on_table = table_shadow.draw({&caster, 1}, top, light, screen);
    const bool on_wall = wall_shadow.draw({&caster, 1}, back, light, screen);

    picture.bind();
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    rays.bind(0);
    grain_texture.bind(1);
    draw_room(view, top, back, box);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    if (flat(wall, view, back)) {
      wall.set("neighbour", plane(top));
      use_shadow(wall, on_wall, wall_shadow);
      screen.draw();
    }
    draw_legs(view, top);
    draw_table_sides(view, top);
    if (flat(table, view, top)) {
      table.set("neighbour", plane(back));
      use_shadow(table, on_table, table_shadow);
      screen.draw();
    }
    draw_dots(view, top, back, on_table, on_wall);
    draw_arm(view);
    if (view.board) {
      const double s = view.board_square;
      const Vector3 x = view.board->rotation * Vector3::UnitX(), y = view.board->rotation * Vector3::UnitY();
      // One white square of margin round the 10 x 7; the origin is the first inner corner.
      if (flat(board, view, {view.board->translation - 2.0 * s * (x + y), x, y, 12.0 * s, 9.0 * s}, true)) {
        board.set("square", static_cast<float>(s));
        screen.draw();
      }
    }
    glDisable(GL_BLEND);
    glDisable(GL_SCISSOR_TEST);
    picture.read_rgb(rgb);
    noise.add(rgb, view.noise_seed);
  }
};

CameraRenderer::CameraRenderer() : impl_(std::make_unique<Impl>()) {}
CameraRenderer::~CameraRenderer() { impl_->context->make_current(); }
void CameraRenderer::render(const TrueView& view, std::vector<std::uint8_t>& rgb) {
  impl_->render(view, rgb);
}

}  // namespace palpate::sim
