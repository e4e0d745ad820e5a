#include "palpate/render/picture_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/render/hand_shape.h"

namespace palpate::render {
namespace {

constexpr std::size_t kSpheres = 4;  // as many as the catcher's shader takes
constexpr double kContactReach = 4;  // radii round a sphere's foot where its contact still shows (1/17 of it)

ShadowReceiver receiver(const scene::SceneSurface& surface) {
  const Vector3 x = surface.corners[1] - surface.corners[0], y = surface.corners[3] - surface.corners[0];
  // Calibrated corners are a rectangle; the second side is squared up all the same, so that the frame stays a
  // frame.
  const Vector3 unit_x = x.normalized();
  const Vector3 unit_y = (y - y.dot(unit_x) * unit_x).normalized();
  return {surface.corners[0], unit_x, unit_y, x.norm(), y.norm()};
}

// In the x-y plane, its area that of the unit circle.
scene::TriangleMesh flat_disc() {
  constexpr std::uint32_t kCorners = 48;
  const double turn = 2.0 * std::numbers::pi / kCorners, radius = std::sqrt(turn / std::sin(turn));
  scene::TriangleMesh mesh;
  for (std::uint32_t i = 0; i < kCorners; ++i) {
    mesh.vertices.push_back(radius * Vector3(std::cos(i * turn), std::sin(i * turn), 0.0));
    if (i >= 2) mesh.triangles.push_back({0, i - 1, i});
  }
  return mesh;
}

WorldBox box_of(const MeshBuffer& mesh, const Matrix4f& X_world_mesh) {
  WorldBox box;
  for (int corner = 0; corner < 8; ++corner) {
    const Vector4f p(corner & 1 ? mesh.low().x() : mesh.high().x(),
                     corner & 2 ? mesh.low().y() : mesh.high().y(),
                     corner & 4 ? mesh.low().z() : mesh.high().z(), 1.0f);
    box.extend((X_world_mesh * p).head<3>().cast<double>());
  }
  return box;
}

PlacedBody placed(BodyCache& cache, const scene::TriangleMesh& mesh, const Quaternion& rotation,
                  const Vector3& position, const scene::DrawItem* item) {
  Matrix4f X = Matrix4f::Identity();
  if (item != nullptr && takes(mesh, item->shape.get())) {  // in World already
    const CachedBody& body = cache.body(mesh, item->shape, item->tint);
    return {&body, X, item, box_of(body.buffer, X)};
  }
  const CachedBody& body = item != nullptr ? cache.body(mesh, {}, item->tint) : cache.body(mesh);
  X.topLeftCorner<3, 3>() = rotation.toRotationMatrix().cast<float>();
  X.topRightCorner<3, 1>() = position.cast<float>();
  return {&body, X, item, box_of(body.buffer, X)};
}

}  // namespace

PictureScene::PictureScene(const CompositorSettings& settings)
    : settings_(settings), cache_(settings.shadow_cells), unit_disc_(flat_disc()) {
  if (settings.map_texels > 0 && settings.shadows) {
    map_real_ = std::make_unique<ShadowMap>(settings.map_texels);
    map_virtual_ = std::make_unique<ShadowMap>(settings.map_texels);
  }
}

void PictureScene::set_arm(const RealScene& real) {
  has_arm_ = real.arm.has_value();
  if (!has_arm_) return;
  const auto& lengths = real.arm->lengths;
  if (!arm_ || lengths.l1 != arm_lengths_.l1 || lengths.l2 != arm_lengths_.l2 ||
      arm_leds_ != real.marker_leds || arm_base_below_ != real.arm_base_below || arm_hand_ != real.hand) {
    arm_lengths_ = lengths;
    arm_leds_ = real.marker_leds;
    arm_base_below_ = real.arm_base_below;
    arm_hand_ = real.hand;
    const std::vector<ArmPart> hand = coarse_hand_parts(arm_hand_);
    ArmShapeSettings shape{.base_below = arm_base_below_, .leds = arm_leds_, .segments = 20, .more = hand};
    arm_ = std::make_unique<ArmBody>(lengths, shape);
    shape.segments = 8;
    arm_coarse_ = std::make_unique<ArmBody>(lengths, shape);
  }
  arm_->move(*real.arm);
  if (arm_throws()) arm_coarse_->move(*real.arm);
}

void PictureScene::set(std::span<const scene::DrawItem> items, const RealScene& real,
                       std::span<const Vector3> eyes, const FullScreen& screen) {
  cache_.next_picture();
  virtual_.clear();
  real_.clear();
  backdrop_.clear();
  casters_.clear();
  flat_casters_.clear();
  darkened_.setEmpty();
  for (const scene::DrawItem& one : items)
    if (one.mesh != nullptr && (!one.mesh->triangles.empty() || takes(*one.mesh, one.shape.get())))
      virtual_.push_back(placed(cache_, *one.mesh, one.rotation, one.position, &one));
  for (const RealBody& one : real.bodies)
    if (one.mesh != nullptr && !one.mesh->triangles.empty())
      real_.push_back(placed(cache_, *one.mesh, one.rotation, one.position, nullptr));
  for (const scene::DrawItem& one : real.backdrop)
    if (one.mesh != nullptr && !one.mesh->triangles.empty())
      backdrop_.push_back(placed(cache_, *one.mesh, one.rotation, one.position, &one));
  set_arm(real);
  surfaces_.clear();
  for (const scene::SceneSurface& surface : real.surfaces) {
    PlacedSurface place;
    place.rectangle = receiver(surface);
    surfaces_.push_back(std::move(place));
  }
  if (!settings_.shadows) return;
  const auto add = [&](const PlacedBody& it) {
    casters_.push_back({&it.body->buffer, it.X_world_mesh, it.body->closed, false, it.item == nullptr});
    flat_casters_.push_back(flat_caster(it));
  };
  for (const PlacedBody& it : virtual_)
    if (it.item->casts_shadow) add(it);
  for (const PlacedBody& it : real_) add(it);
  if (has_arm_ && arm_throws()) {
    casters_.push_back({&arm_coarse_->mesh(), Matrix4f::Identity(), true, false, true});
    flat_casters_.push_back(casters_.back());
  }
  throw_on_surfaces(real, eyes, screen);
  if (map_real_ && !(virtual_.empty() && real_.empty() && !has_arm_)) throw_on_bodies();
}

// A sphere throws the shadow of the circle in which rays of the lamp touch it: a flat disc is far cheaper.
ShadowCaster PictureScene::flat_caster(const PlacedBody& it) const {
  const ShadowCaster triangles{&it.body->buffer, it.X_world_mesh, it.body->closed, settings_.shadow_cells > 0,
                               it.item == nullptr};
  const double radius = it.sphere_radius();
  if (radius <= 0.0) return triangles;
  const Vector3 to_lamp = settings_.light.lamp - it.item->position;
  const double distance = to_lamp.norm();
  if (distance < 2.0 * radius) return triangles;
  const Vector3 z = to_lamp / distance, x = z.unitOrthogonal();
  const double share = radius / distance, across = radius * std::sqrt(1.0 - share * share);
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.col(0).head<3>() = across * x;
  m.col(1).head<3>() = across * z.cross(x);
  m.col(2).head<3>() = z;
  m.col(3).head<3>() = it.item->position + radius * share * z;
  return {&unit_disc_, m.cast<float>(), false, false, false};
}

void PictureScene::throw_on_surfaces(const RealScene& real, std::span<const Vector3> eyes,
                                     const FullScreen& screen) {
  while (planar_.size() < real.surfaces.size())
    planar_.push_back(std::make_unique<PlanarShadow>(settings_.surface_texels));
  for (std::size_t i = 0; i < surfaces_.size(); ++i) {
    PlacedSurface& surface = surfaces_[i];
    const bool front_seen = std::any_of(eyes.begin(), eyes.end(), [&](const Vector3& eye) {
      return surface.normal().dot(eye - surface.rectangle.corner) > 0;
    });
    if (!front_seen) continue;
    find_contacts(surface);
    // Real bodies come last in the list.
    const auto count =
        settings_.real_shadows
            ? flat_casters_.size()
            : static_cast<std::size_t>(std::count_if(flat_casters_.begin(), flat_casters_.end(),
                                                     [](const auto& c) { return !c.real; }));
    if (planar_[i]->draw(std::span(flat_casters_).first(count), surface.rectangle, settings_.light, screen)) {
      surface.shadow = planar_[i].get();
      const Vector4f part = surface.shadow->part();
      if (!surface.darkened) surface.area = part;
      const Vector2f low = surface.area.head<2>().cwiseMin(part.head<2>());
      const Vector2f high =
          (surface.area.head<2>() + surface.area.tail<2>()).cwiseMax(part.head<2>() + part.tail<2>());
      surface.area << low, high - low;
      surface.darkened = true;
    }
  }
}

void PictureScene::find_contacts(PlacedSurface& surface) const {
  const ShadowReceiver& r = surface.rectangle;
  Eigen::AlignedBox2d area;
  for (const PlacedBody& it : virtual_) {
    const double radius = it.sphere_radius();
    if (radius <= 0.0 || !it.item->casts_shadow || surface.spheres.size() == kSpheres) continue;
    const Vector3& centre = it.item->position;
    const Vector3 from = centre - r.corner;
    const double height = surface.normal().dot(from), a = from.dot(r.side_x), b = from.dot(r.side_y);
    const double reach = kContactReach * radius;
    if (height < 0.0 || height > reach || a < -reach || b < -reach || a > r.width + reach ||
        b > r.height + reach)
      continue;
    surface.spheres.push_back(Eigen::Vector4d(centre.x(), centre.y(), centre.z(), radius).cast<float>());
    area.extend(Eigen::Vector2d(std::clamp(a - reach, 0.0, r.width), std::clamp(b - reach, 0.0, r.height)));
    area.extend(Eigen::Vector2d(std::clamp(a + reach, 0.0, r.width), std::clamp(b + reach, 0.0, r.height)));
  }
  if (!area.isEmpty()) {
    surface.darkened = true;
    surface.area << area.min().cast<float>(), area.sizes().cast<float>();
  }
  surface.spheres.resize(kSpheres, Vector4f::Zero());
}

void PictureScene::throw_on_bodies() {
  WorldBox receivers, throwers, real;
  for (const PlacedBody& it : virtual_) {
    receivers.extend(it.box);
    if (it.item->casts_shadow) throwers.extend(it.box);
  }
  for (const PlacedBody& it : real_) real.extend(it.box);
  if (has_arm_) real.extend(box_of(arm_coarse_->mesh(), Matrix4f::Identity()));
  // What virtual bodies may darken of the real ones: what lies in their boxes, drawn out away from the lamp.
  if (!real.isEmpty() && !throwers.isEmpty()) {
    const Vector3 lamp = settings_.light.lamp;
    double farthest = 0.0;
    for (int i = 0; i < 8; ++i)
      farthest = std::max(farthest, (real.corner(static_cast<WorldBox::CornerType>(i)) - lamp).norm());
    WorldBox drawn_out = throwers;
    for (int i = 0; i < 8; ++i) {
      const Vector3 ray = throwers.corner(static_cast<WorldBox::CornerType>(i)) - lamp;
      drawn_out.extend(lamp + ray * std::max(1.0, farthest / std::max(ray.norm(), 1e-3)));
    }
    darkened_ = drawn_out.intersection(real);
    if (!darkened_.isEmpty()) receivers.extend(darkened_);
  }
  if (receivers.isEmpty()) receivers = real;
  map_place_ = shadow_map_place(receivers.center(), 0.5 * receivers.diagonal().norm() + 0.005,
                                settings_.light, settings_.map_texels);
  std::vector<ShadowCaster> of_kind;
  for (const bool kind : {false, true}) {
    of_kind.clear();
    std::copy_if(casters_.begin(), casters_.end(), std::back_inserter(of_kind),
                 [kind](const ShadowCaster& c) { return c.real == kind; });
    (kind ? map_real_ : map_virtual_)->draw(of_kind, map_place_);
  }
}

void PictureScene::use_maps(Program& program) const {
  if (!map_real_) return;
  map_real_->bind(2);
  map_virtual_->bind(3);
  program.set("map_real", 2).set("map_virtual", 3);
  set_shadow_map(program, map_place_, settings_.map_texels);
}

}  // namespace palpate::render
