#include "palpate/compositor/compositor.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <stdexcept>

#include "palpate/compositor/compositor_shaders.h"
#include "palpate/draw/arm_body.h"
#include "palpate/draw/context.h"
#include "palpate/draw/planar_shadow.h"
#include "palpate/draw/projection.h"

namespace palpate {
namespace {

using draw::Matrix4f;
using draw::Program;
using draw::Vector3f;
using draw::Vector4f;

constexpr double kNear = 0.03, kFar = 8.0;  // m

// Colour in linear light; mirror straight on, at the edge, the lamp's image.
struct Look {
  Vector3f albedo, surface;
};
Look look(Material material) {
  switch (material) {
    case Material::ball:
      return {{0.86f, 0.30f, 0.035f}, {0.010f, 0.10f, 0.10f}};
    case Material::bat_front:
      return {{0.42f, 0.020f, 0.018f}, {0.015f, 0.12f, 0.06f}};
    case Material::bat_back:
      return {{0.022f, 0.022f, 0.024f}, {0.020f, 0.14f, 0.06f}};
    case Material::handle:
      return {{0.48f, 0.28f, 0.12f}, {0.020f, 0.10f, 0.10f}};
    case Material::highlight:
      return {{0.16f, 0.62f, 0.22f}, {0.030f, 0.20f, 0.20f}};
  }
  return {};
}

std::uint64_t hash(const void* data, std::size_t bytes) {
  std::uint64_t h = 1469598103934665603ull;
  const auto* at = static_cast<const unsigned char*>(data);
  for (; bytes >= 8; bytes -= 8, at += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, at, 8);
    h = (h ^ word) * 0x9e3779b97f4a7c15ull;
    h ^= h >> 29;
  }
  for (; bytes > 0; --bytes, ++at) h = (h ^ *at) * 1099511628211ull;
  return h;
}

// Every edge belongs to two triangles.
bool closed(const TriangleMesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) edges.emplace_back(t[i], t[(i + 1) % 3]);
  }
  std::sort(edges.begin(), edges.end());
  for (const auto& [a, b] : edges) {
    if (!std::binary_search(edges.begin(), edges.end(), std::pair{b, a})) return false;
  }
  return true;
}

draw::ShadowReceiver receiver(const SceneSurface& surface) {
  const Vector3 x = surface.corners[1] - surface.corners[0], y = surface.corners[3] - surface.corners[0];
  // Calibrated corners are a rectangle; the second side is squared up all the same, so that the frame stays a
  // frame.
  const Vector3 unit_x = x.normalized();
  const Vector3 unit_y = (y - y.dot(unit_x) * unit_x).normalized();
  return {surface.corners[0], unit_x, unit_y, x.norm(), y.norm()};
}

// Pixels of the picture that something covers; grows.
struct Box {
  double left = 1e9, above = 1e9, right = -1e9, below = -1e9;
  bool everything = false;
  void take(const CameraModel& camera, const Vector3& p) {
    if (p.z() < kNear) {
      everything = true;
      return;
    }
    const Pixel pixel = camera.project_undistorted(p);
    left = std::min(left, pixel.x()), right = std::max(right, pixel.x());
    above = std::min(above, pixel.y()), below = std::max(below, pixel.y());
  }
  // x, y, width, height, cut to the picture.
  std::array<int, 4> pixels(const CameraModel& camera) const {
    if (everything) return {0, 0, camera.width, camera.height};
    const auto whole = [](double x, int most) {
      return static_cast<int>(std::clamp(x, 0.0, static_cast<double>(most)));
    };
    const int l = whole(std::floor(left) - 2, camera.width), a = whole(std::floor(above) - 2, camera.height);
    const int r = whole(std::ceil(right) + 3, camera.width), b = whole(std::ceil(below) + 3, camera.height);
    return {l, a, std::max(0, r - l), std::max(0, b - a)};
  }
};

}  // namespace

struct Compositor::Impl {
  std::shared_ptr<draw::Context> context = draw::Context::required();
  CompositorSettings settings;
  draw::FullScreen screen;
  Program undistort{"compositor/undistort", draw::kFullScreen, kUndistortFragment},
      item{"compositor/item", kSolidVertex, item_fragment()},
      phantom{"compositor/phantom", kSolidVertex, kNothingFragment},
      catcher{"compositor/catcher", kCatcherVertex, catcher_fragment()},
      over{"compositor/over", draw::kFullScreen, kOverFragment};
  draw::MeshBuffer unit_square{rectangle_mesh(Vector3::Zero(), Vector3::UnitX(), Vector3::UnitY())};

  draw::Texture background;
  draw::Target layer, picture;

  struct Body {
    std::uint64_t topology = 0, shape = 0, last_used = 0;
    bool closed = false;
    draw::MeshBuffer buffer;
  };
  std::map<const TriangleMesh*, Body> bodies;  // looked up, never walked in an order that shows
  std::uint64_t frame = 0;

  std::vector<std::unique_ptr<draw::PlanarShadow>> shadows;  // one per surface
  std::unique_ptr<draw::ArmBody> arm;
  PhantomLengths arm_lengths;
  std::vector<Vector3> arm_leds;
  double arm_base_below = 0.0;

  explicit Impl(const CompositorSettings& s) : settings(s) {
    if (s.samples != 1 && s.samples != 4) throw std::invalid_argument("compositor: samples must be 1 or 4");
  }

  void prepare(const CameraModel& camera) {
    if (picture && picture.width() == camera.width && picture.height() == camera.height) return;
    background = draw::Texture(camera.width, camera.height, draw::Format::rgb8, draw::Filter::linear);
    layer = draw::Target(camera.width, camera.height, draw::Format::rgba8, true, settings.samples);
    picture = draw::Target(camera.width, camera.height, draw::Format::rgb8, false);
  }

  const Body& body(const TriangleMesh& mesh) {
    Body& known = bodies[&mesh];
    known.last_used = frame;
    const auto topology = hash(mesh.triangles.data(), mesh.triangles.size() * sizeof(mesh.triangles[0])) + 1;
    const auto shape = hash(mesh.vertices.data(), mesh.vertices.size() * sizeof(mesh.vertices[0])) + 1;
    if (known.topology != topology || known.shape != shape) {
      const draw::ShadedMesh shaded = draw::shaded(mesh);
      if (known.topology != topology) known.closed = closed(mesh);
      known.buffer.upload(shaded);
      known.topology = topology;
      known.shape = shape;
    }
    return known;
  }

  void prepare_arm(const RealScene& real) {
    if (!real.arm) return;
    const auto& lengths = real.arm->lengths;
    if (!arm || lengths.l1 != arm_lengths.l1 || lengths.l2 != arm_lengths.l2 ||
        arm_leds != real.marker_leds || arm_base_below != real.arm_base_below) {
      arm_lengths = lengths;
      arm_leds = real.marker_leds;
      arm_base_below = real.arm_base_below;
      arm = std::make_unique<draw::ArmBody>(
          lengths, draw::ArmShapeSettings{.base_below = arm_base_below, .leds = arm_leds, .segments = 20});
    }
    arm->move(*real.arm);
  }

  void draw_background(const CameraImage& image, const CameraModel& camera) {
    background.upload(image.rgb.data());
    picture.bind();
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_BLEND);
    glDisable(GL_DEPTH_TEST);
    background.bind(0);
    const auto& d = camera.distortion;
    undistort.use()
        .set("image", 0)
        .set("k", Vector4f(Eigen::Vector4d(camera.fx, camera.fy, camera.cx, camera.cy).cast<float>()))
        .set("size", draw::Vector2f(static_cast<float>(camera.width), static_cast<float>(camera.height)))
        .set("lens", Vector4f(Eigen::Vector4d(d[0], d[1], d[2], d[3]).cast<float>()))
        .set("lens_k3", static_cast<float>(d[4]));
    screen.draw();
  }

  struct Placed {
    const Body* body;
    Matrix4f X_world_mesh;
    const DrawItem* item;
  };
  std::vector<Placed> placed;
  std::vector<draw::ShadowCaster> casters;
  std::vector<char> shadowed;  // surface by surface

  // Shadows of virtual things; and what of the picture they and the things touch.
  Box place(std::span<const DrawItem> items, const RealScene& real, const CameraModel& camera,
            const Pose<CameraOptical, World>& X_camera_world) {
    Box box;
    placed.clear();
    casters.clear();
    shadowed.assign(real.surfaces.size(), 0);
    for (const DrawItem& one : items) {
      if (one.mesh == nullptr || one.mesh->triangles.empty()) continue;
      const Pose<World, Bat> X{one.rotation, one.position};  // any body frame
      placed.push_back({&body(*one.mesh), draw::matrix4(X), &one});
      const Placed& it = placed.back();
      for (int corner = 0; corner < 8; ++corner) {
        const Vector3 p(corner & 1 ? it.body->buffer.low().x() : it.body->buffer.high().x(),
                        corner & 2 ? it.body->buffer.low().y() : it.body->buffer.high().y(),
                        corner & 4 ? it.body->buffer.low().z() : it.body->buffer.high().z());
        box.take(camera, (X_camera_world * (X * Point<Bat>{p})).m);
      }
      if (one.casts_shadow) casters.push_back({&it.body->buffer, it.X_world_mesh, it.body->closed});
    }
    if (!settings.shadows || casters.empty()) return box;
    while (shadows.size() < real.surfaces.size()) shadows.push_back(std::make_unique<draw::PlanarShadow>());
    for (std::size_t i = 0; i < real.surfaces.size(); ++i) {
      const draw::ShadowReceiver r = receiver(real.surfaces[i]);
      const Vector3 from_eye = r.corner - X_camera_world.inverse().translation;
      if (r.side_x.cross(r.side_y).dot(from_eye) >= 0) continue;  // its front is not seen
      shadowed[i] = shadows[i]->draw(casters, r, settings.light, screen);
      if (!shadowed[i]) continue;
      const Vector4f part = shadows[i]->part();
      for (const auto& [a, b] : {std::pair{0, 0}, std::pair{1, 0}, std::pair{0, 1}, std::pair{1, 1}}) {
        const Vector3 p = r.corner + (part[0] + a * part[2]) * r.side_x + (part[1] + b * part[3]) * r.side_y;
        box.take(camera, (X_camera_world * Point<World>{p}).m);
      }
    }
    return box;
  }

  void draw_phantoms(const RealScene& real, const Matrix4f& to_clip) {
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    phantom.use().set("to_clip", to_clip);
    // A little behind their true place: shadows and things that touch them lie in the same plane.
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(1.0f, 8.0f);
    for (const SceneSurface& surface : real.surfaces) {
      const draw::ShadowReceiver r = receiver(surface);
      Matrix4f m = Matrix4f::Identity();
      m.col(0).head<3>() = (r.width * r.side_x).cast<float>();
      m.col(1).head<3>() = (r.height * r.side_y).cast<float>();
      m.col(2).head<3>() = r.side_x.cross(r.side_y).cast<float>();
      m.col(3).head<3>() = r.corner.cast<float>();
      phantom.set("to_world", m);
      unit_square.draw();
    }
    glDisable(GL_POLYGON_OFFSET_FILL);
    if (real.arm) {
      phantom.set("to_world", Matrix4f(Matrix4f::Identity()));
      glEnable(GL_CULL_FACE);
      arm->mesh().draw();
      glDisable(GL_CULL_FACE);
    }
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  }

  void draw_shadows(const RealScene& real, const Matrix4f& to_clip) {
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    glDepthMask(GL_FALSE);
    catcher.use().set("to_clip", to_clip).set("shadow", 0);
    draw::set_light(catcher, settings.light);
    for (std::size_t i = 0; i < real.surfaces.size(); ++i) {
      if (!shadowed[i]) continue;
      const draw::ShadowReceiver r = receiver(real.surfaces[i]);
      shadows[i]->texture().bind(0);
      catcher.set("corner", Vector3f(r.corner.cast<float>()))
          .set("side_x", Vector3f(r.side_x.cast<float>()))
          .set("side_y", Vector3f(r.side_y.cast<float>()))
          .set("part", shadows[i]->part());
      unit_square.draw();
    }
    glDepthMask(GL_TRUE);
    glDisable(GL_BLEND);
  }

  void draw_items(const RealScene& real, const Matrix4f& to_clip, const Vector3& eye) {
    item.use().set("to_clip", to_clip).set("eye", Vector3f(eye.cast<float>()));
    draw::set_light(item, settings.light);
    for (const Placed& it : placed) {
      const Look how = look(it.item->material);
      // The surface below, if any: the one whose front it is nearest to.
      Vector4f ground(0, 1, 0, 1e3f);
      double nearest = 1e9;
      for (const SceneSurface& surface : real.surfaces) {
        const draw::ShadowReceiver r = receiver(surface);
        const Vector3 n = r.side_x.cross(r.side_y), from = it.item->position - r.corner;
        const double height = n.dot(from), a = from.dot(r.side_x), b = from.dot(r.side_y);
        if (height < -0.05 || height >= nearest || a < 0 || b < 0 || a > r.width || b > r.height) continue;
        nearest = height;
        ground = Eigen::Vector4d(n.x(), n.y(), n.z(), -n.dot(r.corner)).cast<float>();
      }
      item.set("to_world", it.X_world_mesh)
          .set("albedo", how.albedo)
          .set("surface", how.surface)
          .set("ground", ground)
          .set("ground_colour", Vector3f(0.16f, 0.18f, 0.20f));
      (it.body->closed ? glEnable : glDisable)(GL_CULL_FACE);
      it.body->buffer.draw();
    }
    glDisable(GL_CULL_FACE);
  }

  void draw(const CameraImage& image, const CameraModel& camera,
            const Pose<World, CameraOptical>& X_world_camera, std::span<const DrawItem> items,
            const RealScene& real, std::vector<std::uint8_t>& rgb) {
    if (image.width != camera.width || image.height != camera.height ||
        image.rgb.size() !=
            static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height) * 3) {
      throw std::invalid_argument("compositor: image of " + std::to_string(image.width) + "x" +
                                  std::to_string(image.height) + " for a camera of " +
                                  std::to_string(camera.width) + "x" + std::to_string(camera.height));
    }
    if (!context->make_current()) throw std::runtime_error("compositor: used on another thread than its own");
    ++frame;
    prepare(camera);
    prepare_arm(real);
    const Pose<CameraOptical, World> X_camera_world = X_world_camera.inverse();
    const Box box = place(items, real, camera, X_camera_world);
    draw_background(image, camera);
    const auto [x, y, width, height] = box.pixels(camera);
    if (!placed.empty() && width > 0 && height > 0) {
      const Matrix4f to_clip = draw::projection_matrix(camera, kNear, kFar) * draw::matrix4(X_camera_world);
      layer.bind();
      glEnable(GL_SCISSOR_TEST);
      glScissor(x, y, width, height);
      glEnable(GL_DEPTH_TEST);
      glDepthFunc(GL_LEQUAL);
      glFrontFace(GL_CW);  // row 0 on top mirrors the window
      glClearColor(0, 0, 0, 0);
      glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
      draw_phantoms(real, to_clip);
      draw_shadows(real, to_clip);
      draw_items(real, to_clip, X_world_camera.translation);
      glFrontFace(GL_CCW);
      glDepthFunc(GL_LESS);
      glDisable(GL_DEPTH_TEST);
      layer.resolve(x, y, width, height);
      picture.bind();
      glEnable(GL_SCISSOR_TEST);
      glScissor(x, y, width, height);
      glEnable(GL_BLEND);
      glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
      layer.texture().bind(0);
      over.use().set("layer", 0);
      screen.draw();
      glDisable(GL_BLEND);
      glDisable(GL_SCISSOR_TEST);
    }
    picture.read_rgb(rgb);
    // Meshes that have not been drawn for a while may be gone; their address may come back as another mesh.
    if (frame % 256 == 0)
      std::erase_if(bodies, [&](const auto& known) { return known.second.last_used + 256 < frame; });
  }
};

Compositor::Compositor(const CompositorSettings& settings) : impl_(std::make_unique<Impl>(settings)) {}
Compositor::~Compositor() { impl_->context->make_current(); }

void Compositor::draw(const CameraImage& image, const CameraModel& camera,
                      const Pose<World, CameraOptical>& X_world_camera, std::span<const DrawItem> items,
                      const RealScene& real, std::vector<std::uint8_t>& rgb_out) {
  impl_->draw(image, camera, X_world_camera, items, real, rgb_out);
}

}  // namespace palpate
