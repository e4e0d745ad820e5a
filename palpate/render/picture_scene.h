// What stands in a picture, on the graphics card, for all its eyes: virtual bodies, real phantoms, and the
// shadows that each throws on the others. World frame, m. Thread: the context's.
#pragma once

#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "palpate/render/arm_body.h"
#include "palpate/render/body_cache.h"
#include "palpate/render/compositor.h"
#include "palpate/render/picture_box.h"
#include "palpate/render/planar_shadow.h"
#include "palpate/render/shadow_map.h"

namespace palpate::render {

struct PlacedBody {
  const CachedBody* body = nullptr;
  Matrix4f X_world_mesh = Matrix4f::Identity();
  const scene::DrawItem* item = nullptr;  // none: a real body
  WorldBox box;
  // m; 0 where it is no sphere. A sphere's middle is its item's position.
  double sphere_radius() const {
    const double radius = item != nullptr ? item->sphere_radius.value_or(0.0) : 0.0;
    return std::isfinite(radius) && radius > 0.0 ? radius : 0.0;
  }
};

struct PlacedSurface {
  ShadowReceiver rectangle;
  const PlanarShadow* shadow = nullptr;  // of virtual things; none falls on it
  Vector4f area = Vector4f::Zero();      // that shadows or contacts darken: x, y, width, height
  std::vector<Vector4f> spheres;         // near it: centre, radius; always four, radius 0 where fewer
  bool darkened = false;
  Vector3 normal() const { return rectangle.side_x.cross(rectangle.side_y); }
};

class PictureScene {
 public:
  explicit PictureScene(const CompositorSettings& settings);

  // Takes things up and throws their shadows; what no eye at `eyes` sees from its front is left out.
  void set(std::span<const scene::DrawItem> items, const RealScene& real, std::span<const Vector3> eyes,
           const FullScreen& screen);

  const std::vector<PlacedBody>& virtual_bodies() const { return virtual_; }
  const std::vector<PlacedBody>& real_bodies() const { return real_; }
  const std::vector<PlacedBody>& backdrop() const { return backdrop_; }
  const std::vector<PlacedSurface>& surfaces() const { return surfaces_; }
  const MeshBuffer* arm() const { return has_arm_ ? &arm_->mesh() : nullptr; }
  // Where virtual bodies may darken real ones; empty where they do not.
  const WorldBox& darkened() const { return darkened_; }
  // Sets the shadow maps' uniforms and binds them to texture units 2 and 3, where there are maps.
  void use_maps(Program& program) const;

 private:
  void set_arm(const RealScene& real);
  bool arm_throws() const { return settings_.shadows && (settings_.real_shadows || map_real_); }
  ShadowCaster flat_caster(const PlacedBody& body) const;
  void throw_on_surfaces(const RealScene& real, std::span<const Vector3> eyes, const FullScreen& screen);
  void find_contacts(PlacedSurface& surface) const;
  void throw_on_bodies();

  CompositorSettings settings_;
  BodyCache cache_;
  MeshBuffer unit_disc_;
  std::vector<PlacedBody> virtual_, real_, backdrop_;
  std::vector<PlacedSurface> surfaces_;
  std::vector<ShadowCaster> casters_, flat_casters_;   // as bodies; as they throw onto a plane
  std::vector<std::unique_ptr<PlanarShadow>> planar_;  // one per surface
  std::unique_ptr<ShadowMap> map_real_, map_virtual_;
  ShadowMapPlace map_place_;
  WorldBox darkened_;

  std::unique_ptr<ArmBody> arm_, arm_coarse_;  // as drawn, and as it throws shadows
  bool has_arm_ = false;
  device::PhantomLengths arm_lengths_;
  std::vector<Vector3> arm_leds_;
  double arm_base_below_ = 0.0;
  device::HoldingHand arm_hand_ = device::HoldingHand::none;
};

}  // namespace palpate::render
