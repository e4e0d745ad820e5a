// What a soft contact takes from the hand beside what it stores: viscosity and friction. Both only dissipate.
//
// Viscosity: the second arm of a standard linear solid, a spring in series with a dashpot, which follows the tip
// in all directions. The dashpot's constant rises from zero with depth; the spring's is fixed, so that nothing
// that changes with depth can give out energy. Its pull along the normal never
// makes the contact stick, nor exceeds `most_viscous_n`; an encoder's step of s changes it by
// viscous_step_bound(s) at most within a tick.
// Friction: a tangential spring from an anchor on the surface (Mindlin), dragged along where Coulomb's limit is
// reached. Where the contact grows stiffer the spring's force stays, where it grows softer its length does:
// otherwise a path of pressing and shearing would give out energy (Elata and Berryman 1996).
// Body's frame, SI. One thread; no allocation.
// Source: Mindlin 1949, "Compliance of elastic bodies in contact"; Elata and Berryman 1996, "Contact
// force-displacement laws and the mechanical behavior of random packs of identical spheres", Mech. Materials 24.
#pragma once

#include "palpate/math/so3.h"
#include "palpate/physics/tissue/tip_field.h"

namespace palpate::physics::tissue {

struct DissipationSettings {
  // Of the dashpot, by which 75 to 225 g held lightly rest within a second of being pressed.
  double damping_n_s_m = 2.0;
  double relaxation_s = 0.001;  // of the arm; its spring is damping / relaxation
  double fade_m = 0.0005;       // depth at which the dashpot has its full size
  double most_viscous_n = 1.0;
  double friction = 0.0;  // Coulomb's coefficient
  double poisson = 0.45;  // for the ratio of tangential to normal stiffness
};

// Throws std::invalid_argument for what makes no sense.
void check_dissipation(const DissipationSettings& settings);

// N: what one step of an encoder, m, can change the viscous force by within a tick of `dt`.
double viscous_step_bound(const DissipationSettings& settings, double step, double dt);

class Dissipation {
 public:
  explicit Dissipation(const DissipationSettings& settings);

  // The contact is over: what was stored is gone.
  void reset();
  // The tip has `moved` since the last tick, `dt` ago, to where the contact is `now`: the force on the tip. dt > 0.
  Vector3 step(const TipEnergy& now, const Vector3& moved, double dt);

  double stored() const;  // J, in both springs
  bool sliding() const { return sliding_; }
  Vector3 viscous() const { return -spring_ * arm_; }  // N

 private:
  double dashpot(const TipEnergy& now) const;
  void limit_normal(const Vector3& normal, double pressed);
  void stretch(const TipEnergy& now, const Vector3& moved);

  DissipationSettings settings_;
  double spring_, ratio_;
  Vector3 arm_ = Vector3::Zero();      // the arm's spring is longer by so much
  Vector3 stretch_ = Vector3::Zero();  // from the anchor, along the surface
  double shear_ = 0.0;                 // N/m, of the tangential spring
  bool sliding_ = false;
};

}  // namespace palpate::physics::tissue
