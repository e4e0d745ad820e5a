#include "application.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "settings.h"

namespace jelly {
namespace {

using palpate::Point;
using palpate::Vector3;
using palpate::World;

constexpr double kCoupling = 450.0, kDamping = 1.5;  // N/m, N s/m: between tip and surface
constexpr double kDampFrom_m = 0.001;                // the damper has its full size at that depth: no jump
constexpr double kBound_n = 7.0;
constexpr double kTeleport_m = 0.05;  // a tip that moves further in one tick was put there
constexpr double kKnock_n = 10.0;     // sideways, for one step

std::vector<Vector3> directions(std::vector<Vector3> areas) {
  for (Vector3& area : areas) area.normalize();
  return areas;
}

Surface surface_of(const SoftBody& body) {
  Surface surface;
  body.copy_to(surface);
  return surface;
}

// N on the hand, in the frame Jelly: a spring between the tip and the surface, and a damper that never pulls.
Vector3 push(const Contact& contact, const Vector3& velocity) {
  if (contact.depth <= 0.0) return Vector3::Zero();
  const double spring = kCoupling * contact.depth;
  const double damper = -kDamping * std::min(1.0, contact.depth / kDampFrom_m) * velocity.dot(contact.normal);
  return std::min(kBound_n, contact.share * std::max(0.0, spring + damper)) * contact.normal;
}

}  // namespace

JellyLaw::JellyLaw(const palpate::Pose<World, JellyFrame>& X_world_jelly, std::vector<Vector3> facing,
                   const Surface& rest)
    : X_world_jelly_(X_world_jelly), facing_(std::move(facing)), surface_(rest) {}

Vector3 JellyLaw::force(const palpate::scene::TipState& tip, double) noexcept {
  moved_.read(surface_);
  const Vector3 place = tip.X_world_tip.translation;
  const Vector3 in_jelly = (X_world_jelly_.inverse() * Point<World>{place}).m;
  const Contact contact = meet(surface_, facing_, in_jelly, kTipRadius);
  // Nothing begins inside of it.
  if ((place - tip_before_).norm() > kTeleport_m) felt_.engaged = false;
  tip_before_ = place;
  if (contact.depth <= 0.0) felt_.engaged = true;
  const bool touching = felt_.engaged && contact.depth > 0.0;
  felt_.presses += touching && !felt_.touching;
  felt_.touching = touching;
  felt_.force = touching ? Vector3(X_world_jelly_.rotation *
                                   push(contact, X_world_jelly_.rotation.conjugate() * tip.velocity))
                         : Vector3(Vector3::Zero());
  found_.write(felt_);
  return felt_.force;
}

JellyApplication::JellyApplication(const palpate::scene::SceneDescription& scene)
    : carried_offset_(scene.carried_offset),
      X_world_jelly_(place_on_table(scene)),
      body_(material_of(scene)),
      facing_(directions(areas_of(body_.rest()))),
      surface_(surface_of(body_)),
      law_(X_world_jelly_, facing_, surface_),
      normals_(kVertices),
      shape_(kVertices * palpate::scene::Shape::kFloatsPerVertex) {
  shape_anew();
}

void JellyApplication::begin() { knocked_ = true; }

void JellyApplication::reset() {
  body_.come_to_rest();
  peak_ = 0.0;
  presses_before_ = law_.newest().presses;
}

void JellyApplication::move(double dt, const Vector3& tip) {
  const Felt& felt = law_.newest();
  contact_ = felt.engaged && tip.allFinite() ? meet(surface_, facing_, tip, kTipRadius) : Contact{};
  if (contact_.depth <= 0.0) contact_.count = 0;
  const Vector3 load = -push(contact_, Vector3::Zero());
  if (std::exchange(knocked_, false)) {
    Contact everywhere;
    everywhere.count = std::min<std::size_t>(Contact::kMost, kVertices);
    for (std::size_t k = 0; k < everywhere.count; ++k) {
      everywhere.vertices[k] = static_cast<std::uint32_t>(k);  // the top
      everywhere.weights[k] = 1.0 / static_cast<double>(everywhere.count);
    }
    body_.advance(dt, everywhere, {kKnock_n, 0.0, 0.0});
  }
  body_.advance(dt, contact_, load);
  body_.copy_to(surface_);
  law_.set_surface(surface_);
}

// Vertices and normals as the picture wants them, in World.
void JellyApplication::shape_anew() {
  std::fill(normals_.begin(), normals_.end(), Vector3::Zero());
  for (const auto& t : body_.rest().triangles) {
    const Vector3 a = surface_.at(t[0]);
    const Vector3 area = (surface_.at(t[1]) - a).cross(surface_.at(t[2]) - a);
    for (const std::uint32_t corner : t) normals_[corner] += area;
  }
  dent_ = 0.0;
  for (std::size_t i = 0; i < kVertices; ++i) {
    const Vector3 at = (X_world_jelly_ * Point<JellyFrame>{surface_.at(i)}).m;
    const Vector3 normal = X_world_jelly_.rotation * normals_[i].normalized();
    for (int k = 0; k < 3; ++k) {
      shape_[6 * i + static_cast<std::size_t>(k)] = static_cast<float>(at[k]);
      shape_[6 * i + 3 + static_cast<std::size_t>(k)] = static_cast<float>(normal[k]);
    }
    dent_ = std::max(dent_, -facing_[i].dot(surface_.at(i) - body_.rest().vertices[i]));
  }
}

void JellyApplication::show(const palpate::scene::TipState& tip, const Felt& felt,
                            palpate::scene::SceneState& state) {
  const Vector3& place = tip.X_world_tip.translation;
  const bool seen = place.allFinite() && tip.velocity.allFinite();
  state.body_count = 3;
  auto& jelly = state.bodies[kJelly];
  jelly.set_p(X_world_jelly_.translation);
  jelly.set_q(X_world_jelly_.rotation);
  auto& stylus = state.bodies[kStylus];
  auto& end = state.bodies[kTip];
  stylus.visible = end.visible = seen;
  if (seen) {
    const Vector3 lever = tip.X_world_tip.rotation * carried_offset_;
    stylus.set_p(place + lever);
    stylus.set_q(tip.X_world_tip.rotation);
    stylus.set_v(tip.velocity + tip.angular_velocity.cross(lever));
    stylus.set_w(tip.angular_velocity);
    // On the surface, not in it: a hand goes as far in as the spring between the two gives way.
    end.set_p(place + X_world_jelly_.rotation * (contact_.depth * contact_.normal));
    end.set_q(tip.X_world_tip.rotation);
    end.set_v(tip.velocity);
  }
  const auto milli = [](double value) {
    return static_cast<std::int32_t>(std::lround(std::min(1e6, 1e3 * value)));
  };
  state.counters[kPresses] = felt.presses - presses_before_;
  state.counters[kForceMn] = milli(felt.force.norm());
  state.counters[kPeakMn] = milli(peak_);
  state.counters[kDentUm] = milli(1e3 * dent_);
  state.continuous.force = {felt.force.x(), felt.force.y(), felt.force.z()};
  state.continuous.touching = felt.touching ? 1 : 0;
  state.continuous.point = end.position;
}

void JellyApplication::step(palpate::Instant<palpate::PhysicsClock>, palpate::Duration dt,
                            const palpate::scene::TipState& tip, palpate::scene::SceneState& state) {
  const Felt& felt = law_.newest();
  peak_ = std::max(peak_, felt.force.norm());
  if (!paused()) {
    move(palpate::to_seconds(dt), (X_world_jelly_.inverse() * Point<World>{tip.X_world_tip.translation}).m);
    shape_anew();
  }
  show(tip, felt, state);
}

}  // namespace jelly
