// TouchApplication: explore a rigid surface with the tip of the stylus, at rest or moving.
//
// The force is its contact law's (touch_law.h), which the haptic tick evaluates; the physics loop moves the
// organ and shows what was found. Bodies: 0 the organ, 1 the stylus (its tip, displaced by the scene's
// carried_offset), 2 the proxy. World frame, SI. Physics thread; step() does not allocate, lock, throw or write
// text.
#pragma once

#include "applications/touch/organ.h"
#include "applications/touch/touch_law.h"
#include "palpate/scene/application.h"

namespace palpate::applications::touch {

inline constexpr int kOrgan = 0, kStylus = 1, kProxy = 2;

// Places in SceneState::counters.
enum Counter : std::size_t {
  kTouches,      // times the surface was met
  kContactMs,    // time in contact
  kForceMn,      // now, mN
  kPeakForceMn,  // so far
  kUnsettled,    // haptic ticks in which the proxy did not come to its end
  kDepthUm,      // now, of the tip below the surface, along its normal, um
  kSliding,      // now, 0 or 1
  kSlips,        // times friction gave way
};

struct Settings {
  double tip_radius = 0.003;  // m
  double sway_hz = 0.25;      // of the motion that Control::begin starts and stops
  double sway_m = 0.006;      // up and down
  double sway_rad = 0.10;     // about the vertical
};

class TouchApplication : public scene::Application {
 public:
  // What is touched, and of what material, say the scene's settings; it stands on the surface "table", a hand's
  // breadth from its near edge. Throws std::invalid_argument for settings out of range.
  explicit TouchApplication(const scene::SceneDescription& scene, const Settings& settings = {});
  TouchApplication(const TouchApplication&) = delete;  // the law refers to the mesh
  TouchApplication& operator=(const TouchApplication&) = delete;

  void step(Instant<PhysicsClock> now, Duration dt, const scene::TipState& tip,
            scene::SceneState& state) override;
  const scene::ImpactEvent& impact() const override { return no_impact_; }
  TouchLaw* contact_law() override { return &law_; }

  const scene::TriangleMesh& surface() const { return surface_; }
  const physics::ProxyState& proxy() const { return shown_.proxy; }  // as of the newest step
  const Pose<World, Organ>& rest() const { return X_world_rest_; }   // of the organ, before it moves

 private:
  void begin() override { swaying_ = !swaying_; }  // the organ begins or ceases to move
  void reset() override;
  void move_organ(double dt);
  void count(const Touching& found);
  void show(const scene::TipState& tip, double dt, scene::SceneState& state);

  scene::SceneDescription scene_;
  Settings settings_;
  scene::TriangleMesh surface_;
  Pose<World, Organ> X_world_rest_, X_world_organ_;
  TouchLaw law_;
  Touching shown_;
  Vector3 velocity_ = Vector3::Zero(), spin_ = Vector3::Zero();  // of the organ
  double phase_ = 0.0;                                           // of its sway, rad
  bool swaying_ = false;
  std::uint64_t resets_ = 0;
  std::array<std::int32_t, scene::SceneState::kCounters> counters_{};
  scene::ImpactEvent no_impact_;
};

}  // namespace palpate::applications::touch
