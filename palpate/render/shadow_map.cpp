#include "palpate/render/shadow_map.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace palpate::render {
namespace {

const char* const kDepthVertex = R"(
layout(location = 0) in vec3 position;
uniform mat4 to_clip;
void main() { gl_Position = to_clip * vec4(position, 1.0); }
)";
const char* const kDepthFragment = R"(
void main() {}
)";

}  // namespace

// The place is moved out of the surface by a texel and a half before it is compared, so that a surface does
// not shade itself; four comparisons, each of four texels, make the edge soft.
const char* const kShadowMapGlsl = R"(
uniform mat4 to_map;
uniform float map_texel, map_step;
float lamp_seen(sampler2DShadow map, vec3 p, vec3 n) {
  vec4 q = to_map * vec4(p + 1.5 * map_texel * n, 1.0);
  vec3 s = q.xyz / q.w * 0.5 + 0.5;
  vec2 d = 0.75 * map_step * vec2(1.0, -1.0);
  return 0.25 * (textureLod(map, vec3(s.xy + d.xx, s.z), 0.0) + textureLod(map, vec3(s.xy + d.xy, s.z), 0.0) +
                 textureLod(map, vec3(s.xy + d.yx, s.z), 0.0) + textureLod(map, vec3(s.xy + d.yy, s.z), 0.0));
}
)";

ShadowMapPlace shadow_map_place(const Vector3& centre, double radius, const device::RoomLight& light,
                                int size) {
  // A lamp inside the sphere has no picture of it: the sphere is cut to what lies before the lamp.
  const double distance = std::max((centre - light.lamp).norm(), 1e-3);
  const double r = std::min(radius, 0.9 * distance);
  const Vector3 z = (centre - light.lamp) / distance, x = z.unitOrthogonal();
  Matrix3 R;  // lamp axes in World: x, y across, z towards the sphere
  R << x, z.cross(x), z;
  const double near = distance - r, far = distance + r;
  const double reach = r / std::sqrt(distance * distance - r * r);  // tangent of the sphere's half angle
  Eigen::Matrix4d projection = Eigen::Matrix4d::Zero(), view = Eigen::Matrix4d::Identity();
  projection(0, 0) = projection(1, 1) = 1.0 / reach;
  projection(2, 2) = (far + near) / (far - near);
  projection(2, 3) = -2.0 * far * near / (far - near);
  projection(3, 2) = 1.0;
  view.topLeftCorner<3, 3>() = R.transpose();
  view.topRightCorner<3, 1>() = -R.transpose() * light.lamp;
  return {(projection * view).cast<float>(), 2.0 * reach * distance / size};
}

ShadowMap::ShadowMap(int size) : size_(size), depth_("shadow/map", kDepthVertex, kDepthFragment) {
  glGenTextures(1, &texture_);
  glBindTexture(GL_TEXTURE_2D, texture_);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, size, size, 0, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT,
               nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  glGenFramebuffers(1, &framebuffer_);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, texture_, 0);
  glDrawBuffer(GL_NONE);
  glReadBuffer(GL_NONE);
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw std::runtime_error("shadow map of " + std::to_string(size) +
                             " texels: incomplete; the driver does not offer this size");
}
ShadowMap::~ShadowMap() {
  glDeleteFramebuffers(1, &framebuffer_);
  glDeleteTextures(1, &texture_);
}

void ShadowMap::draw(std::span<const ShadowCaster> casters, const ShadowMapPlace& place) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, size_, size_);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_CULL_FACE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_TRUE);
  glClear(GL_DEPTH_BUFFER_BIT);
  glEnable(GL_DEPTH_CLAMP);  // what is nearer to the lamp than the sphere still throws its shadow
  depth_.use();
  for (const ShadowCaster& caster : casters) {
    depth_.set("to_clip", Matrix4f(place.to_clip * caster.X_world_mesh));
    caster.mesh->draw();
  }
  glDisable(GL_DEPTH_CLAMP);
  glDisable(GL_DEPTH_TEST);
}

void ShadowMap::bind(int unit) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, texture_);
}

void set_shadow_map(Program& program, const ShadowMapPlace& place, int size) {
  program.set("to_map", place.to_clip)
      .set("map_texel", static_cast<float>(place.texel))
      .set("map_step", 1.0f / static_cast<float>(size));
}

}  // namespace palpate::render
