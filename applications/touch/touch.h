// TouchApplication: explore a rigid surface with the tip of the stylus, at rest or moving.
//
// A proxy of the tip's size stays on the surface; a virtual coupling, spring and damper, pulls tip and proxy
// together, and that pull is what the hand feels. Bodies: 0 the organ, 1 the stylus (its tip, displaced by
// the scene's bat_offset), 2 the proxy. The force begins once the tip has been clear of the surface and
// outside. World frame, SI. Physics thread; step() does not allocate, lock, throw or write text. Source:
// palpate/physics/proxy.h; Colgate, Stanley and Brown 1995 (virtual coupling).
#pragma once

#include "applications/touch/organ.h"
#include "palpate/physics/proxy.h"
#include "palpate/scene/application.h"

namespace palpate::applications::touch {

inline constexpr int kOrgan = 0, kStylus = 1, kProxy = 2;

// Places in SceneState::counters.
enum Counter : std::size_t {
  kTouches,      // times the surface was met
  kContactMs,    // time in contact
  kForceMn,      // now, mN
  kPeakForceMn,  // so far
  kUnsettled,    // steps in which the proxy did not come to its end
  kDepthUm,      // now, of the tip below the surface, along its normal, um
  kSliding,      // now, 0 or 1
  kSlips,        // times friction gave way
};

// What arms of this class render without buzzing (docs/theory/stability.md).
inline constexpr double kMostStiffness = 800.0, kMostDamping = 3.0;  // N/m, N s/m

struct Settings {
  double tip_radius = 0.003;  // m
  double sway_hz = 0.25;      // of the motion that Control::serve starts and stops
  double sway_m = 0.006;      // up and down
  double sway_rad = 0.10;     // about the vertical
};

class TouchApplication : public scene::Application {
 public:
  // What is touched, and of what material, says scene.touched; it stands on the surface "table", a hand's
  // breadth from its near edge. Throws std::invalid_argument for settings out of range.
  explicit TouchApplication(const scene::SceneDescription& scene, const Settings& settings = {});
  TouchApplication(const TouchApplication&) = delete;  // the proxy refers to the mesh
  TouchApplication& operator=(const TouchApplication&) = delete;

  void step(Instant<PhysicsClock> now, Duration dt, const scene::TipState& tip,
            scene::SceneState& state) override;
  const scene::ImpactEvent& impact() const override { return no_impact_; }

  const scene::TriangleMesh& surface() const { return surface_; }
  const physics::ProxyState& proxy() const { return proxy_.state(); }
  const Pose<World, Organ>& rest() const { return X_world_rest_; }  // of the organ, before it moves

 private:
  void serve() override { swaying_ = !swaying_; }  // the organ begins or ceases to move
  void reset() override;
  void move_organ(double dt);
  bool outside(const Vector3& p) const;
  Vector3 pull(const Vector3& tip, const Vector3& velocity) const;

  scene::SceneDescription scene_;
  Settings settings_;
  scene::TriangleMesh surface_;
  physics::CollisionMesh mesh_;
  physics::Proxy proxy_;
  Pose<World, Organ> X_world_rest_, X_world_organ_;
  Vector3 velocity_ = Vector3::Zero(), spin_ = Vector3::Zero();  // of the organ
  double phase_ = 0.0;                                           // of its sway, rad
  bool swaying_ = false, engaged_ = false;
  double contact_s_ = 0.0;
  Vector3 tip_before_ = Vector3::Zero();
  std::array<std::int32_t, scene::SceneState::kCounters> counters_{};
  scene::ImpactEvent no_impact_;
};

}  // namespace palpate::applications::touch
