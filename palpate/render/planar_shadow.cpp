#include "palpate/render/planar_shadow.h"

#include <epoxy/gl.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/render/context.h"
#include "palpate/render/shadow_gather.h"

namespace palpate::render {
namespace {

constexpr int kSide = 4, kSamples = kSide * kSide;  // tiles, one per point of the lamp

// A body's point is thrown along the ray from the lamp sample; the division is left to the card (w), so that
// edges stay straight and what is above the lamp is clipped.
const char* const kCastVertex = R"(
layout(location = 0) in vec3 position;
uniform mat4 to_plane;      // mesh to rectangle: x, y along its sides, z out of it
uniform vec3 samples[16];   // of the lamp, rectangle axes
uniform vec4 part;          // x, y, width, height
out float gl_ClipDistance[5];
void main() {
  vec3 p = (to_plane * vec4(position, 1.0)).xyz;
  vec3 s = samples[gl_InstanceID];
  float w = s.z - p.z;
  vec2 q = s.xy * w + (p.xy - s.xy) * s.z;       // times w
  vec2 t = (q - part.xy * w) / part.zw;          // 0..w inside
  gl_ClipDistance[0] = t.x;
  gl_ClipDistance[1] = w - t.x;
  gl_ClipDistance[2] = t.y;
  gl_ClipDistance[3] = w - t.y;
  gl_ClipDistance[4] = p.z;                      // what is behind the rectangle throws nothing on it
  vec2 tile = vec2(gl_InstanceID % 4, gl_InstanceID / 4);
  gl_Position = vec4((tile * w + t) * 0.5 - w, 0.0, w);
}
)";
const char* const kCastFragment = R"(
out vec4 colour;
void main() { colour = vec4(1.0); }
)";

const char* const kGatherFragment = R"(
uniform sampler2D tiles;
uniform float size;
out vec4 colour;
void main() {
  vec2 p = gl_FragCoord.xy;
  vec2 sum = vec2(0.0);
  for (int i = 0; i < 16; ++i) {
    vec2 tile = vec2(i % 4, i / 4) * size;
    vec2 blur = vec2((i & 1) == 0 ? 0.5 : -0.5, (i & 2) == 0 ? 0.5 : -0.5);  // four texels for one look-up
    vec2 hidden = textureLod(tiles, (tile + clamp(p + blur, vec2(0.5), vec2(size - 0.5))) / (4.0 * size), 0.0).rg;
    sum += vec2(max(hidden.r, hidden.g), hidden.g);
  }
  colour = vec4(sum / 16.0, 0.0, 1.0);
}
)";

// A sunflower of points fills the lamp's disc, which looks `towards`, evenly (Vogel 1979).
std::vector<Vector3f> samples_of_lamp(const Vector3& lamp, const Vector3& towards, double radius) {
  const Vector3 across = towards.unitOrthogonal(), along = towards.cross(across);
  std::vector<Vector3f> samples(kSamples);
  for (int i = 0; i < kSamples; ++i) {
    const double r = radius * std::sqrt((i + 0.5) / kSamples);
    const double a = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    samples[static_cast<std::size_t>(i)] =
        (lamp + r * (std::cos(a) * across + std::sin(a) * along)).cast<float>();
  }
  return samples;
}

}  // namespace

PlanarShadow::PlanarShadow(int size, std::optional<bool> by_processor)
    : cast_("shadow/cast", kCastVertex, kCastFragment),
      gather_("shadow/gather", kFullScreen, kGatherFragment),
      by_processor_(by_processor.value_or(Context::required()->is_software())),
      tiles_(kSide * size, kSide * size, Format::rg8, false),
      result_(size, size, Format::rg8, false),
      averaged_(size, size, Format::rg8, Filter::linear) {}

bool PlanarShadow::draw(std::span<const ShadowCaster> casters, const ShadowReceiver& receiver,
                        const device::RoomLight& light, const FullScreen& screen) {
  const Vector3 normal = receiver.side_x.cross(receiver.side_y);
  Eigen::Matrix4d to_plane = Eigen::Matrix4d::Identity();
  to_plane.row(0).head<3>() = receiver.side_x;
  to_plane.row(1).head<3>() = receiver.side_y;
  to_plane.row(2).head<3>() = normal;
  to_plane.topRightCorner<3, 1>() = -to_plane.topLeftCorner<3, 3>() * receiver.corner;

  const Vector3 lamp = to_plane.topLeftCorner<3, 3>() * light.lamp + to_plane.topRightCorner<3, 1>();
  if (lamp.z() < 0.05) return false;
  const Vector3 towards = (Vector3(0.5 * receiver.width, 0.5 * receiver.height, 0) - lamp).normalized();
  const std::vector<Vector3f> samples = samples_of_lamp(lamp, towards, light.lamp_radius);

  // The part that can be dark: the virtual bodies' boxes, thrown from the lamp's samples.
  using Box = Eigen::AlignedBox2d;
  Box part;
  std::vector<Box> boxes;
  for (const ShadowCaster& caster : casters) {
    Box& box = boxes.emplace_back();
    const Eigen::Matrix4d m = to_plane * caster.X_world_mesh.cast<double>();
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector4d place(corner & 1 ? caster.mesh->low().x() : caster.mesh->high().x(),
                                  corner & 2 ? caster.mesh->low().y() : caster.mesh->high().y(),
                                  corner & 4 ? caster.mesh->low().z() : caster.mesh->high().z(), 1.0);
      Vector3 p = (m * place).head<3>();
      p.z() = std::clamp(p.z(), 0.0, 0.9 * lamp.z());
      for (const Vector3f& sample : samples) {
        const Vector3 s = sample.cast<double>();
        const Eigen::Vector2d q = s.head<2>() + (p - s).head<2>() * (s.z() / (s.z() - p.z()));
        box.extend(q);
      }
    }
    if (!caster.real) part.extend(box);
  }
  const double border = 0.004;  // m; keeps the outermost texels light
  part.min().array() -= border;
  part.max().array() += border;
  part = part.intersection(Box(Eigen::Vector2d::Zero(), Eigen::Vector2d(receiver.width, receiver.height)));
  if (!((part.min().array() < part.max().array()).all())) return false;
  part_ << part.min().cast<float>(), part.sizes().cast<float>();

  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_BLEND);
  glDisable(GL_DEPTH_TEST);
  tiles_.bind();
  glClearColor(0, 0, 0, 0);
  glClear(GL_COLOR_BUFFER_BIT);
  for (int i = 0; i < 5; ++i) glEnable(GL_CLIP_DISTANCE0 + static_cast<GLenum>(i));
  cast_.use().set("samples", samples).set("part", part_);
  for (std::size_t i = 0; i < casters.size(); ++i) {
    const ShadowCaster& caster = casters[i];
    if (!boxes[i].intersects(part)) continue;
    cast_.set("to_plane", Matrix4f(to_plane.cast<float>() * caster.X_world_mesh));
    (caster.closed ? glEnable : glDisable)(GL_CULL_FACE);
    glColorMask(caster.real ? GL_FALSE : GL_TRUE, caster.real ? GL_TRUE : GL_FALSE, GL_FALSE, GL_FALSE);
    if (caster.coarse)
      caster.mesh->draw_coarse(kSamples);
    else
      caster.mesh->draw(kSamples);
  }
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDisable(GL_CULL_FACE);
  for (int i = 0; i < 5; ++i) glDisable(GL_CLIP_DISTANCE0 + static_cast<GLenum>(i));
  if (by_processor_) {
    tiles_.read_rg(samples_);
    gather_tiles(samples_, averaged_.width(), average_);
    averaged_.upload(average_.data());
    return true;
  }
  result_.bind();
  tiles_.texture().bind(0);
  gather_.use().set("tiles", 0).set("size", static_cast<float>(result_.width()));
  screen.draw();
  return true;
}

}  // namespace palpate::render
