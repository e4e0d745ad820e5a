// Shadows on bodies of any shape: depth as the lamp sees it, over the sphere that holds what is looked at.
//
// Coarser than PlanarShadow, whose edges soften with distance; meant for the small shadows that arm and
// virtual bodies throw on each other. What stands between the lamp and the sphere counts as well. World frame, metres.
// Source: Williams (1978), "Casting curved shadows on curved surfaces"; Reeves, Salesin, Cook (1987) for the
// averaged comparison. Thread: the context's.
#pragma once

#include <span>

#include "palpate/render/planar_shadow.h"

namespace palpate::render {

// Where a map lies: made once for all maps of a picture.
struct ShadowMapPlace {
  Matrix4f to_clip = Matrix4f::Identity();  // World to the map's clip coordinates
  double texel = 0.0;                       // m on the sphere's middle, for a map of `size` texels
};
ShadowMapPlace shadow_map_place(const Vector3& centre, double radius, const device::RoomLight& light,
                                int size);

class ShadowMap {
 public:
  explicit ShadowMap(int size);
  ~ShadowMap();
  ShadowMap(const ShadowMap&) = delete;
  ShadowMap& operator=(const ShadowMap&) = delete;

  // Leaves its own framebuffer bound.
  void draw(std::span<const ShadowCaster> casters, const ShadowMapPlace& place);
  void bind(int unit) const;

 private:
  int size_;
  Program depth_;
  unsigned texture_ = 0, framebuffer_ = 0;
};

// GLSL: float lamp_seen(sampler2DShadow map, vec3 p, vec3 n): share of the lamp that a body's place p with
// normal n sees past the map's casters. Uniforms: mat4 to_map (World to map), float map_texel (m), map_step
// (1 / size).
extern const char* const kShadowMapGlsl;
// Sets these uniforms.
void set_shadow_map(Program& program, const ShadowMapPlace& place, int size);

}  // namespace palpate::render
