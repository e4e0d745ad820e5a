#include "palpate/sim/camera_renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "palpate/render/arm_body.h"
#include "palpate/render/context.h"
#include "palpate/render/planar_shadow.h"
#include "palpate/sim/internal/arm_picture.h"
#include "palpate/sim/internal/camera_shaders.h"
#include "palpate/sim/internal/grain.h"
#include "palpate/sim/internal/picture_tiles.h"
#include "palpate/sim/internal/true_hand.h"
#include "palpate/sim/lens_rays.h"
#include "palpate/sim/per_lens.h"
#include "palpate/sim/sensor_noise.h"

namespace palpate::sim {
namespace {

using render::Program;
using render::ShadowReceiver;

constexpr double kTableThickness = 0.024, kTableHeight = 0.74;  // m
constexpr float kFalloff = 0.16f;  // light lost in the corners, per squared ray length

ShadowReceiver rectangle(const std::array<Vector3, 4>& corners) {
  const Vector3 x = corners[1] - corners[0], y = corners[3] - corners[0];
  return {corners[0], x.normalized(), y.normalized(), x.norm(), y.norm()};
}
Vector3 normal(const ShadowReceiver& r) { return r.side_x.cross(r.side_y); }
render::Vector4f plane(const ShadowReceiver& r) {
  const Vector3 n = normal(r);
  return Eigen::Vector4d(n.x(), n.y(), n.z(), -n.dot(r.corner)).cast<float>();
}

}  // namespace

// A surface's inside, its inside under a shadow, and its edge.
struct SurfacePrograms {
  SurfacePrograms(const std::string& name, std::string (*shader)(SurfacePart))
      : plain(name, kTileVertex, shader(SurfacePart::plain)),
        shadowed(name + " shadowed", kTileVertex, shader(SurfacePart::shadowed)),
        edge(name + " edge", kTileVertex, shader(SurfacePart::edge)) {}
  Program plain, shadowed, edge;
};

struct CameraRenderer::Impl {
  std::shared_ptr<render::Context> context = render::Context::required();
  device::RoomLight light;
  render::FullScreen screen;
  SurfacePrograms table{"sim/table", table_shader}, wall{"sim/wall", wall_shader};
  Program side{"sim/side", render::kFullScreen, side_shader()}, room{"sim/room", kTileVertex, room_shader()},
      leg{"sim/leg", render::kFullScreen, leg_shader()},
      floor{"sim/floor", render::kFullScreen, floor_shader()},
      dot{"sim/dot", render::kFullScreen, dot_shader()}, ball{"sim/ball", render::kFullScreen, ball_shader()},
      board{"sim/board", render::kFullScreen, board_shader()};
  render::PlanarShadow table_shadow{160}, wall_shadow{96};
  render::Texture grain_texture{256, 256, render::Format::r8, render::Filter::linear_repeat};

  struct LensParts {
    explicit LensParts(const device::CameraModel& lens) : LensParts(lens, lens_rays(lens)) {}
    render::Texture rays;
    render::Target picture;
    PictureTiles tiles;
    ArmPicture arm_picture;

   private:
    LensParts(const device::CameraModel& lens, const LensRays& all)
        : rays(lens.width, lens.height, render::Format::rg32f, render::Filter::nearest),
          picture(lens.width, lens.height, render::Format::rgb8, false),
          tiles(lens.width, lens.height, all.ray) {
      rays.upload(all.ray.data());
      arm_picture.prepare(lens, all.low, all.high);
    }
  };
  PerLens<LensParts> lenses;
  const render::Target& picture() { return lenses.latest().picture; }
  PictureTiles& tiles() { return lenses.latest().tiles; }

  device::PhantomLengths arm_lengths;
  std::vector<Vector3> arm_leds;
  double arm_foot = 0.0;
  TrueHand arm_hand;
  std::unique_ptr<render::ArmBody> arm_body, arm_shadow_body;
  std::optional<std::array<Vector3, 4>> floor_table;  // none drawn yet
  render::Target boards{512, 512, render::Format::rgb8, false};
  SensorNoise noise{0.0};

  Impl() { grain_texture.upload(grain(256).data()); }

  void prepare_bodies(const TrueView& view, const ShadowReceiver& top) {
    // The arm stands on the table.
    const double foot = std::max(0.0, (view.X_world_base.translation - top.corner).dot(normal(top)));
    if (!arm_body || view.lengths.l1 != arm_lengths.l1 || view.lengths.l2 != arm_lengths.l2 ||
        view.marker_leds != arm_leds || !(view.hand == arm_hand) || std::abs(foot - arm_foot) > 1e-9) {
      arm_lengths = view.lengths;
      arm_leds = view.marker_leds;
      arm_foot = foot;
      arm_hand = view.hand;
      const auto body = [&](int segments, int round_bones) {
        const auto hand = true_hand_parts(arm_hand, round_bones);
        return std::make_unique<render::ArmBody>(
            arm_lengths, render::ArmShapeSettings{
                             .base_below = foot, .leds = arm_leds, .segments = segments, .more = hand});
      };
      arm_body = body(24, 16);
      arm_shadow_body = body(8, 8);
    }
  }

  void common(Program& program) {
    program.use().set("rays", 0).set("grain", 1).set("shadow", 2).set("falloff", kFalloff);
    render::set_light(program, light);
  }

  // A rectangle as the camera of `view` has it.
  struct Seen {
    Seen(const TrueView& view, const ShadowReceiver& r) {
      const Pose<CameraOptical, World> X = view.X_world_camera.inverse();
      corner = (X * Point<World>{r.corner}).m;
      x = X.rotation * r.side_x;
      y = X.rotation * r.side_y;
      Matrix3 plane_to_ray;
      plane_to_ray << x, y, corner;
      to_plane = plane_to_ray.inverse();
    }
    bool from_behind() const { return x.cross(y).dot(corner) >= 0.0; }
    Vector3 corner, x, y;
    Matrix3 to_plane;
  };

  void flat_uniforms(Program& program, const TrueView& view, const ShadowReceiver& r, const Seen& seen) {
    common(program);
    program.set("to_plane", render::Matrix3f(seen.to_plane.cast<float>()))
        .set("size", render::Vector2f(static_cast<float>(r.width), static_cast<float>(r.height)))
        .set("corner", render::Vector3f(r.corner.cast<float>()))
        .set("side_x", render::Vector3f(r.side_x.cast<float>()))
        .set("side_y", render::Vector3f(r.side_y.cast<float>()))
        .set("eye", render::Vector3f(view.X_world_camera.translation.cast<float>()))
        .set("shadow_part", render::Vector4f(render::Vector4f::Zero()));
  }

  // Sets up a small flat thing's uniforms and the part of the picture it can touch; false when it cannot be
  // seen.
  bool flat(Program& program, const TrueView& view, const ShadowReceiver& r, bool two_sided = false) {
    const Seen seen(view, r);
    if (!two_sided && seen.from_behind()) return false;
    const Vector3 &c = seen.corner, x = r.width * seen.x, y = r.height * seen.y;
    if (!scissor(pixel_box(view.lens, {c, c + x, c + x + y, c + y}))) return false;
    flat_uniforms(program, view, r, seen);
    return true;
  }

  // Table or wall, tile by tile. Nothing behind a tile that it fills needs to be drawn.
  struct Surface {
    ShadowReceiver place;
    Seen seen;
    std::vector<TileCover> cover;  // empty: seen from behind
  };
  Surface surface(const TrueView& view, const ShadowReceiver& r) {
    Surface s{r, Seen(view, r), {}};
    if (!s.seen.from_behind())
      s.cover = tiles().cover(s.seen.to_plane, Eigen::Vector2d::Zero(), Eigen::Vector2d(r.width, r.height));
    return s;
  }

  void draw_surface(SurfacePrograms& programs, const TrueView& view, const Surface& s,
                    const ShadowReceiver& neighbour, const render::PlanarShadow* shadow) {
    if (s.cover.empty()) return;
    glDisable(GL_SCISSOR_TEST);
    std::vector<TileCover> dark(tiles().count(), TileCover::none);
    if (shadow != nullptr) {
      const Eigen::Vector4d part = shadow->part().cast<double>();
      dark = tiles().cover(s.seen.to_plane, part.head<2>(), part.head<2>() + part.tail<2>());
    }
    const auto draw = [&](Program& program, const auto& wanted) {
      flat_uniforms(program, view, s.place, s.seen);
      program.set("neighbour", plane(neighbour));
      use_shadow(program, shadow != nullptr, shadow);
      std::vector<char> marked(s.cover.size());
      for (std::size_t i = 0; i < marked.size(); ++i) marked[i] = wanted(s.cover[i], dark[i]);
      tiles().draw(marked);
    };
    glDisable(GL_BLEND);
    draw(programs.plain, [](TileCover own, TileCover in_dark) {
      return own == TileCover::whole && in_dark == TileCover::none;
    });
    draw(programs.shadowed, [](TileCover own, TileCover in_dark) {
      return own == TileCover::whole && in_dark != TileCover::none;
    });
    glEnable(GL_BLEND);
    draw(programs.edge, [](TileCover own, TileCover) { return own == TileCover::part; });
  }

  void use_shadow(Program& program, bool any, const render::PlanarShadow* shadow) {
    if (!any) return;
    shadow->texture().bind(2);
    program.set("shadow_part", shadow->part());
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
    floor.set("room_low", render::Vector3f(box.low.cast<float>()))
        .set("room_high", render::Vector3f(box.high.cast<float>()))
        .set("table_corner", render::Vector3f(top.corner.cast<float>()))
        .set("table_x", render::Vector3f(top.side_x.cast<float>()))
        .set("table_y", render::Vector3f(top.side_y.cast<float>()))
        .set("table_size", render::Vector2f(static_cast<float>(top.width), static_cast<float>(top.height)))
        .set("texels",
             render::Vector2f(static_cast<float>(boards.width()), static_cast<float>(boards.height())));
    screen.draw();
  }

  // Where neither surface hides it.
  void draw_room(const TrueView& view, const Surface& top, const Surface& back, const Room& box) {
    std::vector<char> marked(tiles().count(), 1);
    for (const Surface* s : {&top, &back})
      for (std::size_t i = 0; i < s->cover.size(); ++i)
        if (s->cover[i] == TileCover::whole) marked[i] = 0;
    glDisable(GL_SCISSOR_TEST);
    common(room);
    boards.texture().bind(3);
    room.set("to_world", render::Matrix3f(view.X_world_camera.matrix().cast<float>()))
        .set("boards", 3)
        .set("eye", render::Vector3f(view.X_world_camera.translation.cast<float>()))
        .set("room_low", render::Vector3f(box.low.cast<float>()))
        .set("room_high", render::Vector3f(box.high.cast<float>()));
    tiles().draw(marked);
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
      const render::PlanarShadow& shadow = lies_on_table ? table_shadow : wall_shadow;
      if ((lies_on_table ? on_table : on_wall) && x.dot(under.side_x) > 0.99 && y.dot(under.side_y) > 0.99) {
        shadow.texture().bind(2);
        render::Vector4f part = shadow.part();
        const Vector3 shift = d.centre - half * (x + y) - under.corner;
        part.x() -= static_cast<float>(shift.dot(under.side_x));
        part.y() -= static_cast<float>(shift.dot(under.side_y));
        dot.set("shadow_part", part);
      }
      screen.draw();
    }
  }

  // Balls lie behind the arm and throw no shadow.
  void draw_balls(const TrueView& view) {
    for (const RealBall& b : view.balls) {
      const Vector3 z = (view.X_world_camera.translation - b.centre).normalized();
      const Vector3 x = z.unitOrthogonal(), y = z.cross(x);
      const double half = 1.2 * b.radius;
      if (!flat(ball, view, {b.centre - half * (x + y), x, y, 2.0 * half, 2.0 * half})) continue;
      ball.set("ball",
               render::Vector4f(
                   Eigen::Vector4d(b.centre.x(), b.centre.y(), b.centre.z(), b.radius).cast<float>()));
      screen.draw();
    }
  }

  void render(const TrueView& view, std::vector<std::uint8_t>& rgb) {
    if (!context->make_current())
      throw std::runtime_error("camera picture: asked for on another thread than its own");
    const ShadowReceiver top = rectangle(view.table), back = rectangle(view.wall);
    lenses.of(view.lens, [](const device::CameraModel& lens) { return LensParts(lens); });
    const Room box = room_round(top, back);
    prepare_floor(view, top, box);
    if (noise.sd() != view.noise_sd) noise = SensorNoise(view.noise_sd);
    prepare_bodies(view, top);
    const render::ArmConfiguration configuration{view.X_world_base, view.lengths, view.theta, view.gimbal,
                                                 view.X_tip_marker};
    arm_body->move(configuration);
    arm_shadow_body->move(configuration);
    const render::ShadowCaster caster{&arm_shadow_body->mesh()};
    const bool on_table = table_shadow.draw({&caster, 1}, top, light, screen);
    const bool on_wall = wall_shadow.draw({&caster, 1}, back, light, screen);

    picture().bind();
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
    lenses.latest().rays.bind(0);
    grain_texture.bind(1);
    const Surface table_seen = surface(view, top), wall_seen = surface(view, back);
    draw_room(view, table_seen, wall_seen, box);
    glEnable(GL_BLEND);
    glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
    draw_surface(wall, view, wall_seen, top, on_wall ? &wall_shadow : nullptr);
    draw_legs(view, top);
    draw_table_sides(view, top);
    draw_surface(table, view, table_seen, back, on_table ? &table_shadow : nullptr);
    draw_dots(view, top, back, on_table, on_wall);
    draw_balls(view);
    lenses.latest().arm_picture.draw(*arm_body, view, light, kFalloff, picture(), screen);
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
    picture().read_rgb(rgb);
    noise.add(rgb, view.noise_seed);
  }
};

CameraRenderer::CameraRenderer() : impl_(std::make_unique<Impl>()) {}
CameraRenderer::~CameraRenderer() { impl_->context->make_current(); }
void CameraRenderer::render(const TrueView& view, std::vector<std::uint8_t>& rgb) {
  impl_->render(view, rgb);
}

}  // namespace palpate::sim
