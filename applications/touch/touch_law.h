// What touch lets a hand feel, in each haptic tick: a proxy of the tip's size stays on the surface; a virtual
// coupling, spring and damper, pulls tip and proxy together, and that pull is the force.
//
// The physics loop moves the organ and hears what was found, through newest-value boxes; neither loop waits.
// The organ's own frame is moved on from its newest place to the time of the tip. The force begins once the
// tip has been clear of the surface and outside. World frame, SI. Source: palpate/physics/proxy.h; Colgate,
// Stanley and Brown 1995 (virtual coupling).
#pragma once

#include "applications/touch/organ.h"
#include "applications/touch/settings.h"
#include "palpate/physics/proxy.h"
#include "palpate/scene/application.h"
#include "palpate/scene/contact_law.h"
#include "palpate/time/triple_buffer.h"

namespace palpate::applications::touch {

// What arms of this class render without buzzing (docs/theory/stability.md).
inline constexpr double kMostStiffness = 800.0, kMostDamping = 3.0;  // N/m, N s/m

// Where the organ is and how it moves, from the physics loop.
struct OrganMotion {
  Instant<PhysicsClock> time;
  Pose<World, Organ> X_world_organ;
  Vector3 velocity = Vector3::Zero(), spin = Vector3::Zero();
  bool paused = false;       // followed, and not felt
  std::uint64_t resets = 0;  // counts below begin anew with each
};

// What the newest tick found.
struct Touching {
  Vector3 force = Vector3::Zero();  // N on the hand
  Vector3 tip = Vector3::Zero();    // that it is the answer to
  bool engaged = false;             // the tip has been outside: there is a proxy
  physics::ProxyState proxy;        // in the Organ frame
  std::uint32_t jumps = 0;          // of the proxy's path: no picture is drawn across these
  std::uint64_t resets = 0;         // that these counts have followed
  int touches = 0, slips = 0, unsettled = 0;
  double contact_s = 0.0, peak_n = 0.0;
};

class TouchLaw : public scene::ContactLaw {
 public:
  // Throws std::invalid_argument for a material out of range.
  TouchLaw(const SurfaceSettings& settings, const scene::TriangleMesh& surface, double tip_radius,
           const Pose<World, Organ>& rest);
  TouchLaw(const TouchLaw&) = delete;  // the proxy refers to the mesh
  TouchLaw& operator=(const TouchLaw&) = delete;

  // --- the haptic thread
  Vector3 force(const scene::TipState& tip, double dt) noexcept override;
  double force_bound() const override { return kBound_n; }
  Duration cost_bound() const override { return std::chrono::microseconds(400); }

  // --- the physics thread
  void move_organ(const OrganMotion& motion) { motion_.write(motion); }
  // The newest; as before where no tick has come since.
  const Touching& newest() {
    found_.read(newest_);
    return newest_;
  }

 private:
  static constexpr double kTeleport_m =
      0.05;  // a tip that moves further in one tick was put there, not moved
  static constexpr double kBound_n =
      20.0;  // beyond any arm of this class: there a spring is a spring no more

  bool outside(const Vector3& p) const;
  Vector3 pull(const Vector3& tip, const Vector3& velocity) const;
  void follow(const scene::TipState& tip, double dt);

  const scene::TriangleMesh& surface_;
  double stiffness_, damping_;
  physics::CollisionMesh mesh_;
  physics::Proxy proxy_;
  Vector3 tip_before_ = Vector3::Zero();
  OrganMotion organ_;
  Touching touching_;  // the haptic thread's
  Touching newest_;    // the physics thread's
  TripleBuffer<OrganMotion> motion_;
  TripleBuffer<Touching> found_;
};

}  // namespace palpate::applications::touch
