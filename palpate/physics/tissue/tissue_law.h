// What a soft body lets a hand feel, in each haptic tick: the gradient of its energy, viscosity and friction, and a
// damping that keeps the sampled whole from giving out more than was put in.
//
// The physics loop moves the body and hears what was felt, through newest-value boxes; neither loop waits. Forces
// are evaluated in the body's frame, moved on from its newest place to the time of the tip.
//
// The contact begins where the tip has been outside. A tip that is pushed so deep that its place no longer tells
// from which side it came (TipEnergy::lost), or that is found beyond the body's middle, is let go: the force it had
// fades within its last direction, by kRelease_n_s, and is gone before it has given back half of what was stored;
// there is none until the tip has been outside again. A tip that jumps further than kTeleport_m within a tick, or is no number, has no force
// at once. World frame, SI.
// Source: docs/theory/tissue.md.
#pragma once

#include <cstdint>

#include "palpate/core/expected.h"
#include "palpate/physics/tissue/dissipation.h"
#include "palpate/physics/tissue/energy_account.h"
#include "palpate/physics/tissue/tip_field.h"
#include "palpate/scene/contact_law.h"
#include "palpate/time/triple_buffer.h"

namespace palpate::physics::tissue {

struct Body;  // frame: of the surface and the field

// Where the body is and how it moves, from the physics loop.
struct BodyMotion {
  Instant<PhysicsClock> time;
  Pose<World, Body> X_world_body;
  Vector3 velocity = Vector3::Zero(), spin = Vector3::Zero();  // of its origin; World
  bool paused = false;                                         // followed, and not felt
  // A second contact (TissueSettings::finger): the centre of its sphere, in the body's frame. It moves in the physics
  // loop's steps, and so does what the tip feels of it.
  bool finger_there = false;
  Vector3 finger = Vector3::Zero();
  std::uint64_t resets = 0;  // counts below begin anew with each
};

// What the newest tick found.
struct TissueTouch {
  Vector3 force = Vector3::Zero();         // N on the hand
  Vector3 static_force = Vector3::Zero();  // of it, what the body's energy asks for
  Vector3 tip = Vector3::Zero();           // that it is the answer to
  bool engaged = false;                    // the tip has been outside
  bool releasing = false;                  // let go, the force fades
  Vector3 finger_force = Vector3::Zero();  // N on the finger, while the tip touches, too
  TipEnergy contact;                       // in the body's frame; of a tip that is not engaged nothing
  double damping = 0.0;                    // N s/m, that keeps it passive
  std::uint64_t resets = 0;                // that these counts have followed
  int touches = 0, slips = 0, lost = 0, damped_ticks = 0;
  double contact_s = 0.0, peak_n = 0.0;
  double created_j = 0.0;  // that contacts have given out in all without its having been put in
};

struct TissueSettings {
  DissipationSettings dissipation;
  double passivity_damping_n_s_m = 4.0;  // at most; 0 switches the account off
  // What a finger of its own radius feels of this body; null: there is none. It must outlive the law.
  const TipField* finger = nullptr;
  double young_pa = 6000.0;  // by which finger and tip feel one another through the body (two_contacts.h)
};

class TissueLaw : public scene::ContactLaw {
 public:
  static constexpr double kTeleport_m = 0.02;
  static constexpr double kRelease_n_s = 20.0;
  static constexpr double kBound_n = 20.0;  // beyond any arm of this class

  // Whether arms of this class render it; the words say what to change.
  static Expected<void> renders(const TipField& field);
  // The field must outlive the law. Throws std::invalid_argument for what renders() refuses, and for settings that
  // make no sense.
  TissueLaw(const TipField& field, const TissueSettings& settings, const Pose<World, Body>& rest);
  TissueLaw(const TissueLaw&) = delete;
  TissueLaw& operator=(const TissueLaw&) = delete;

  // --- the haptic thread
  Vector3 force(const scene::TipState& tip, double dt) noexcept override;
  double force_bound() const override { return kBound_n * (1.0 + 1e-9); }
  Duration cost_bound() const override { return std::chrono::microseconds(100); }

  // --- the physics thread
  void move_body(const BodyMotion& motion) { motion_.write(motion); }
  // The newest; as before where no tick has come since.
  const TissueTouch& newest() {
    found_.read(newest_);
    return newest_;
  }

 private:
  void let_go();
  void disengage();
  TipEnergy shared(const TipEnergy& alone, const Vector3& p, const Vector3& finger);
  void meet_finger(TipEnergy& now, const Vector3& p);
  bool still_on_its_side(const TipEnergy& now, const Vector3& moved) const;
  Vector3 press(const TipEnergy& now, const Vector3& moved, const Vector3& velocity, double dt);
  Vector3 release(const Vector3& moved, double dt);
  void follow(const scene::TipState& tip, double dt);

  const TipField& field_;
  Dissipation dissipation_;
  EnergyAccount account_;
  double passivity_damping_;
  const TipField* finger_;
  double young_, poisson_;
  bool finger_before_there_ = false;
  Vector3 finger_before_ = Vector3::Zero();
  Vector3 tip_before_ = Vector3::Zero(), place_before_ = Vector3::Zero();  // World, Body
  bool seen_before_ = false;
  Vector3 held_ =
      Vector3::Zero();  // Body: the force of the last tick, and while it is let go what is left of it
  Vector3 held_earlier_ = Vector3::Zero();  // the same of the tick before
  double left_j_ = 0.0;                     // that what is let go may still give out
  BodyMotion body_;
  TissueTouch touch_;   // the haptic thread's
  TissueTouch newest_;  // the physics thread's
  TripleBuffer<BodyMotion> motion_;
  TripleBuffer<TissueTouch> found_;
};

}  // namespace palpate::physics::tissue
