// A contact law: what an application wants felt for as long as a contact lasts, as a function that the haptic
// tick itself evaluates. Tip in, force out: no second loop's delay lies between the two.
//
// Whatever it asks for, the haptic loop limits (docs/theory/forces.md); how forces return after an outage does
// not depend on it. World frame, SI. Source of the idea, an intermediate representation that the force loop
// keeps: Adachi, Kumano, Ogino 1995; Mark et al. 1996.
#pragma once

#include "palpate/scene/tip_state.h"

namespace palpate::scene {

class ContactLaw {
 public:
  virtual ~ContactLaw() = default;

  // Force on the hand for the coming tick, N. `tip` is as measured for this tick, of finite numbers, where it
  // was last seen if the arm is silent; `dt` is the time since the last call, s, 0 in the first.
  // The haptic thread, once a tick, about 1 kHz: no lock, no allocation, no system call, no text. What another
  // thread moves (a body's pose) reaches it through a TripleBuffer.
  virtual Vector3 force(const TipState& tip, double dt) noexcept = 0;

  // What it promises; asked for once, before the first tick.
  // The largest force it ever asks for, N, > 0. What lies above is no force: it fades until less is asked for.
  virtual double force_bound() const = 0;
  // The longest that force() takes, > 0; half of the tick's period counts where that is less. A law that takes
  // longer again and again is switched off until a person resets.
  virtual Duration cost_bound() const = 0;
};

}  // namespace palpate::scene
