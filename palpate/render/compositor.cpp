#include "palpate/render/compositor.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "palpate/render/compositor_shaders.h"
#include "palpate/render/context.h"
#include "palpate/render/picture_box.h"
#include "palpate/render/picture_looks.h"
#include "palpate/render/picture_scene.h"
#include "palpate/render/projection.h"
#include "palpate/render/undistortion_map.h"

namespace palpate::render {
namespace {

constexpr double kFar = 8.0;  // m

ShaderChoice choice_of(const CompositorSettings& settings) {
  return {settings.encoding, settings.samples, settings.shadows && settings.map_texels > 0};
}

const CompositorSettings& checked(const CompositorSettings& s) {
  const auto wrong = [](const std::string& what) { throw std::invalid_argument("compositor: " + what); };
  if (s.samples != 1 && s.samples != 4 && s.samples != 8)
    wrong("samples is " + std::to_string(s.samples) + "; 1, 4 or 8 is expected");
  if (s.surface_texels < 16 || s.surface_texels > 1024)
    wrong("surface_texels is " + std::to_string(s.surface_texels) + "; 16 to 1024 is expected");
  if (s.map_texels != 0 && (s.map_texels < 64 || s.map_texels > 4096))
    wrong("map_texels is " + std::to_string(s.map_texels) + "; 0 or 64 to 4096 is expected");
  return s;
}

// A driver may offer fewer samples than are asked for.
CompositorSettings offered(CompositorSettings settings) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_SAMPLES, &most);
  if (settings.samples == 8 && most < 8) settings.samples = 4;
  return settings;
}

}  // namespace

struct Compositor::Impl {
  std::shared_ptr<Context> context = Context::required();
  CompositorSettings settings;
  FullScreen screen;
  PictureScene scene;
  Program background, over, item, darkened, phantom, catcher;
  MeshBuffer unit_square{scene::rectangle_mesh(Vector3::Zero(), Vector3::UnitX(), Vector3::UnitY())};
  Texture image;
  Target layer, picture, model;
  std::array<UndistortionMap, 2> maps;  // of the eyes' cameras, where the processor undoes their lenses
  std::function<void(const char*)> watcher;

  explicit Impl(const CompositorSettings& s)
      : settings(offered(checked(s))),
        scene(settings),
        background("compositor/background", kFullScreen, background_fragment()),
        over("compositor/over", kFullScreen, over_fragment(choice_of(settings))),
        item("compositor/item", kSolidVertex, item_fragment(choice_of(settings))),
        darkened("compositor/darkened", kSolidVertex, darkened_fragment(choice_of(settings))),
        phantom("compositor/phantom", kSolidVertex, kNothingFragment),
        catcher("compositor/catcher", kCatcherVertex, catcher_fragment()) {}

  void done(const char* stage) const {
    if (!watcher) return;
    glFinish();
    watcher(stage);
  }

  void prepare(const device::CameraModel& camera) {
    if (picture && picture.width() == camera.width && picture.height() == camera.height) return;
    image = Texture(camera.width, camera.height, Format::rgb8, Filter::linear);
    layer = Target(camera.width, camera.height, Format::rgba8, true, settings.samples);
    picture = Target(camera.width, camera.height, Format::rgb8, false);
    model = {};
  }

  // Whether the processor undoes the lens: a software renderer takes three times as long for it.
  bool undone_beforehand(const Viewpoint& eye) const {
    return eye.image != nullptr && settings.lens_on_processor.value_or(context->is_software());
  }

  // Uniforms of the shaders that look at the camera's image.
  void set_camera(Program& program, const Viewpoint& eye) {
    const device::CameraModel& c = eye.camera;
    device::LensCoefficients d{};
    const bool undone = eye.image == nullptr || undone_beforehand(eye);
    if (!undone) d = c.distortion;
    (eye.image != nullptr ? image : model.texture()).bind(0);
    program.use()
        .set("image", 0)
        .set("k", Vector4f(Eigen::Vector4d(c.fx, c.fy, c.cx, c.cy).cast<float>()))
        .set("size", Vector2f(static_cast<float>(c.width), static_cast<float>(c.height)))
        .set("lens", Vector4f(Eigen::Vector4d(d[0], d[1], d[2], d[3]).cast<float>()))
        .set("lens_more", Vector4f(Eigen::Vector4d(d[4], d[5], d[6], d[7]).cast<float>()))
        .set("fisheye", !undone && c.kind == device::LensKind::fisheye ? 1 : 0);
  }

  static Matrix4f square_to(const ShadowReceiver& r) {
    Matrix4f m = Matrix4f::Identity();
    m.col(0).head<3>() = (r.width * r.side_x).cast<float>();
    m.col(1).head<3>() = (r.height * r.side_y).cast<float>();
    m.col(2).head<3>() = r.side_x.cross(r.side_y).cast<float>();
    m.col(3).head<3>() = r.corner.cast<float>();
    return m;
  }

  // The real arm and real bodies, with `program` in use.
  void draw_real_bodies(Program& program) {
    for (const PlacedBody& it : scene.real_bodies()) {
      program.set("to_world", it.X_world_mesh);
      (it.body->closed ? glEnable : glDisable)(GL_CULL_FACE);
      it.body->buffer.draw();
    }
    if (const MeshBuffer* arm = scene.arm()) {
      program.set("to_world", Matrix4f(Matrix4f::Identity()));
      glEnable(GL_CULL_FACE);
      arm->draw();
    }
    glDisable(GL_CULL_FACE);
  }

  void draw_phantoms(const Matrix4f& to_clip) {
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    phantom.use().set("to_clip", to_clip);
    // A little behind their true place: shadows and things that touch them lie in the same plane.
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(1.0f, 8.0f);
    for (const PlacedSurface& surface : scene.surfaces()) {
      phantom.set("to_world", square_to(surface.rectangle));
      unit_square.draw();
    }
    glDisable(GL_POLYGON_OFFSET_FILL);
    draw_real_bodies(phantom);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  }

  void draw_shadows(const Matrix4f& to_clip, const Vector3& eye, bool in_image) {
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    glDepthMask(GL_FALSE);
    catcher.use().set("to_clip", to_clip).set("shadow", 0).set("in_image", in_image ? 1.0f : 0.0f);
    set_light(catcher, settings.light);
    for (const PlacedSurface& surface : scene.surfaces()) {
      const ShadowReceiver& r = surface.rectangle;
      if (!surface.darkened || surface.normal().dot(eye - r.corner) <= 0) continue;
      if (surface.shadow != nullptr) surface.shadow->texture().bind(0);
      catcher.set("corner", Vector3f(r.corner.cast<float>()))
          .set("side_x", Vector3f(r.side_x.cast<float>()))
          .set("side_y", Vector3f(r.side_y.cast<float>()))
          .set("area", surface.area)
          .set("spheres", surface.spheres)
          .set("part", surface.shadow != nullptr ? surface.shadow->part() : Vector4f(Vector4f::Zero()));
      unit_square.draw();
    }
    if (!scene.darkened().isEmpty()) {
      darkened.use().set("to_clip", to_clip);
      set_light(darkened, settings.light);
      scene.use_maps(darkened);
      draw_real_bodies(darkened);
    }
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
  }

  void use_item(const Matrix4f& to_clip, const Vector3& eye) {
    item.use()
        .set("to_clip", to_clip)
        .set("eye", Vector3f(eye.cast<float>()))
        .set("ground", Vector4f(0, 1, 0, 1e3f))
        .set("ground_colour", Vector3f(0.16f, 0.18f, 0.20f))
        .set("shaded_by", Vector2f(1, 1))
        .set("tinted", 0.0f)
        .set("above", Vector3f(Vector3f::Zero()))
        .set("below", Vector3f(Vector3f::Zero()));
    set_light(item, settings.light);
    scene.use_maps(item);
  }
  void set_look(const scene::Look& look) {
    item.set("albedo", Vector3f(look.colour[0], look.colour[1], look.colour[2]))
        .set("surface", Vector3f(look.mirror, look.mirror_edge, look.gloss));
  }

  void set_tint(const scene::DrawItem& it) {
    const bool tinted = takes(*it.mesh, it.tint.get());
    item.set("tinted", tinted ? 1.0f : 0.0f);
    if (tinted)
      item.set("above", Vector3f(it.tint->above.data())).set("below", Vector3f(it.tint->below.data()));
  }

  // Plane of the surface below a thing, if any: the one whose front it is nearest to.
  Vector4f ground_below(const Vector3& place) const {
    Vector4f ground(0, 1, 0, 1e3f);
    double nearest = 1e9;
    for (const PlacedSurface& surface : scene.surfaces()) {
      const ShadowReceiver& r = surface.rectangle;
      const Vector3 n = surface.normal(), from = place - r.corner;
      const double height = n.dot(from), a = from.dot(r.side_x), b = from.dot(r.side_y);
      if (height < -0.05 || height >= nearest || a < 0 || b < 0 || a > r.width || b > r.height) continue;
      nearest = height;
      ground = Eigen::Vector4d(n.x(), n.y(), n.z(), -n.dot(r.corner)).cast<float>();
    }
    return ground;
  }

  void draw_items(const Matrix4f& to_clip, const Vector3& eye) {
    use_item(to_clip, eye);
    for (const PlacedBody& it : scene.virtual_bodies()) {
      set_look(it.item->look);
      set_tint(*it.item);
      item.set("to_world", it.X_world_mesh).set("ground", ground_below(it.item->position));
      (it.body->closed ? glEnable : glDisable)(GL_CULL_FACE);
      it.body->buffer.draw();
    }
    glDisable(GL_CULL_FACE);
  }

  static void begin_depth() {
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LEQUAL);
    glFrontFace(GL_CW);  // row 0 on top mirrors the window
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  }
  static void end_depth() {
    glFrontFace(GL_CCW);
    glDepthFunc(GL_LESS);
    glDisable(GL_DEPTH_TEST);
  }

  // In place of an image: the real things as plain shapes.
  void draw_model(const Viewpoint& eye, const Matrix4f& to_clip) {
    if (!model) model = Target(eye.camera.width, eye.camera.height, Format::rgba8, true, settings.samples);
    model.bind();
    glDisable(GL_SCISSOR_TEST);
    glClearColor(0.66f, 0.69f, 0.72f, 1);
    begin_depth();
    use_item(to_clip, eye.X_world_camera.translation);
    item.set("shaded_by", Vector2f(0, 0));
    for (const PlacedSurface& surface : scene.surfaces()) {
      set_look(std::abs(surface.normal().y()) > 0.7 ? kLevelLook : kUprightLook);
      item.set("to_world", square_to(surface.rectangle));
      unit_square.draw();
    }
    for (const PlacedBody& it : scene.backdrop()) {
      set_look(it.item->look);
      item.set("to_world", it.X_world_mesh);
      (it.body->closed ? glEnable : glDisable)(GL_CULL_FACE);
      it.body->buffer.draw();
    }
    glDisable(GL_CULL_FACE);
    item.set("shaded_by", Vector2f(1, 0));  // by virtual ones later, as over an image
    set_look(scene.real_bodies().empty() ? kArmLook : kBodyLook);
    draw_real_bodies(item);
    end_depth();
    model.resolve(0, 0, model.width(), model.height());
  }

  // The background where `box` is not, as up to four strips round it.
  void draw_background(const Viewpoint& eye, const std::array<int, 4>& box) {
    const int w = eye.camera.width, h = eye.camera.height;
    const auto [x, y, width, height] = box;
    picture.bind();
    glDisable(GL_BLEND);
    set_camera(background, eye);
    glEnable(GL_SCISSOR_TEST);
    const auto strip = [&](int left, int above, int wide, int high) {
      if (wide <= 0 || high <= 0) return;
      glScissor(left, above, wide, high);
      screen.draw();
    };
    strip(0, 0, w, y);
    strip(0, y, x, height);
    strip(x + width, y, w - x - width, height);
    strip(0, y + height, w, h - y - height);
    glDisable(GL_SCISSOR_TEST);
  }

  void draw_layer(const Viewpoint& eye, const Matrix4f& to_clip, const std::array<int, 4>& box) {
    layer.bind();
    glEnable(GL_SCISSOR_TEST);
    glScissor(box[0], box[1], box[2], box[3]);
    glClearColor(0, 0, 0, 0);
    begin_depth();
    draw_phantoms(to_clip);
    draw_shadows(to_clip, eye.X_world_camera.translation, eye.image != nullptr);
    draw_items(to_clip, eye.X_world_camera.translation);
    end_depth();
    done("layer");
    picture.bind();
    glScissor(box[0], box[1], box[2], box[3]);
    if (layer.samples() > 1)
      layer.bind_samples(1);
    else
      layer.texture().bind(1);
    set_camera(over, eye);
    over.set("layer", 1);
    screen.draw();
    glDisable(GL_SCISSOR_TEST);
    done("over");
  }

  // What of the picture virtual things and their shadows touch.
  std::array<int, 4> touched(const Viewpoint& eye, const Pose<CameraOptical, World>& X_camera_world) const {
    if (scene.virtual_bodies().empty()) return {0, 0, 0, 0};
    PixelBox box;
    for (const PlacedBody& it : scene.virtual_bodies()) box.take(eye.camera, X_camera_world, it.box);
    box.take(eye.camera, X_camera_world, scene.darkened());
    for (const PlacedSurface& surface : scene.surfaces()) {
      const ShadowReceiver& r = surface.rectangle;
      if (!surface.darkened || surface.normal().dot(eye.X_world_camera.translation - r.corner) <= 0) continue;
      for (const auto& [a, b] : {std::pair{0, 0}, std::pair{1, 0}, std::pair{0, 1}, std::pair{1, 1}}) {
        const Vector3 p = r.corner + (surface.area[0] + a * surface.area[2]) * r.side_x +
                          (surface.area[1] + b * surface.area[3]) * r.side_y;
        box.take(eye.camera, (X_camera_world * Point<World>{p}).m);
      }
    }
    const auto pixels = box.pixels(eye.camera);
    return pixels[2] > 0 && pixels[3] > 0 ? pixels : std::array<int, 4>{0, 0, 0, 0};
  }

  // The lens undone straight into the picture, of which only what virtual things touch goes through the renderer.
  void draw_round_layer(const Viewpoint& eye, UndistortionMap& map, std::uint8_t* rgb, int stride) {
    const Pose<CameraOptical, World> X_camera_world = eye.X_world_camera.inverse();
    if (!map.is_of(eye.camera)) map = UndistortionMap(eye.camera);
    map.undo(eye.image->rgb, rgb, stride);
    done("background");
    const auto box = touched(eye, X_camera_world);
    if (box[2] <= 0) return;
    image.upload(rgb, stride, box);
    done("upload");
    draw_layer(eye, projection_matrix(eye.camera, kNearest, kFar) * matrix4(X_camera_world), box);
    picture.read_rgb(rgb, stride, box);
    done("read");
  }

  void draw_eye(const Viewpoint& eye) {
    const Pose<CameraOptical, World> X_camera_world = eye.X_world_camera.inverse();
    const Matrix4f to_clip = projection_matrix(eye.camera, kNearest, kFar) * matrix4(X_camera_world);
    if (eye.image != nullptr)
      image.upload(eye.image->rgb.data());
    else
      draw_model(eye, to_clip);
    done("upload");
    const auto box = touched(eye, X_camera_world);
    draw_background(eye, box);
    done("background");
    if (box[2] > 0) draw_layer(eye, to_clip, box);
  }

  void draw(std::span<const Viewpoint> eyes, std::span<const scene::DrawItem> items, const RealScene& real,
            std::vector<std::uint8_t>& rgb) {
    if (eyes.empty()) throw std::invalid_argument("compositor: no eye to draw for; at least one is expected");
    const device::CameraModel& first = eyes.front().camera;
    std::vector<Vector3> places;
    for (const Viewpoint& eye : eyes) {
      const auto size_text = [](int w, int h) { return std::to_string(w) + "x" + std::to_string(h); };
      const device::CameraModel& c = eye.camera;
      if (c.width != first.width || c.height != first.height)
        throw std::invalid_argument("compositor: eyes of " + size_text(first.width, first.height) + " and " +
                                    size_text(c.width, c.height) + "; side by side they must have one size");
      if (eye.image != nullptr && (eye.image->width != c.width || eye.image->height != c.height ||
                                   eye.image->rgb.size() != static_cast<std::size_t>(c.width) *
                                                                static_cast<std::size_t>(c.height) * 3))
        throw std::invalid_argument("compositor: image of " + size_text(eye.image->width, eye.image->height) +
                                    " for a camera of " + size_text(c.width, c.height));
      places.push_back(eye.X_world_camera.translation);
    }
    if (!context->make_current()) throw std::runtime_error("compositor: used on another thread than its own");
    prepare(first);
    scene.set(items, real, places, screen);
    done("shadows");
    const auto width = static_cast<std::size_t>(first.width);
    rgb.resize(3 * width * static_cast<std::size_t>(first.height) * eyes.size());
    glFlush();  // what was asked for goes on while the processor looks at the image
    const auto stride = static_cast<int>(width * eyes.size());
    for (std::size_t i = 0; i < eyes.size(); ++i) {
      std::uint8_t* part = rgb.data() + 3 * width * i;
      if (undone_beforehand(eyes[i])) {
        draw_round_layer(eyes[i], maps[std::min(i, maps.size() - 1)], part, stride);
        continue;
      }
      draw_eye(eyes[i]);
      picture.read_rgb(part, stride);
      done("read");
    }
  }
};

Compositor::Compositor(const CompositorSettings& settings) : impl_(std::make_unique<Impl>(settings)) {}
Compositor::~Compositor() { impl_->context->make_current(); }

void Compositor::draw(const device::CameraImage& image, const device::CameraModel& camera,
                      const Pose<World, CameraOptical>& X_world_camera,
                      std::span<const scene::DrawItem> items, const RealScene& real,
                      std::vector<std::uint8_t>& rgb_out) {
  const Viewpoint eye{&image, camera, X_world_camera};
  impl_->draw({&eye, 1}, items, real, rgb_out);
}

void Compositor::draw(std::span<const Viewpoint> eyes, std::span<const scene::DrawItem> items,
                      const RealScene& real, std::vector<std::uint8_t>& rgb_out) {
  impl_->draw(eyes, items, real, rgb_out);
}

void Compositor::watch_stages(std::function<void(const char* stage)> watcher) {
  impl_->watcher = std::move(watcher);
}

}  // namespace palpate::render
