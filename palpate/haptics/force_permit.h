// Whether an arm may be given forces at all, and how strong; every composition asks.
//
// A permit is had in one way only: from what the driver says of its arm and what the rig holds. A computed arm has one.
// Any other needs the rig's check of its forces (`palpate calibrate forces`), done on this very arm with this model and
// zero; where no known weight told their size, and of an arm that states its place, the peak stays at 1 N. A permit
// made of nothing permits nothing, and a HapticLoop without one commands no force, whatever is requested.
//
// Value; any thread; held() does not allocate.
#pragma once

#include <cstdint>
#include <string>

#include "palpate/device/opened.h"
#include "palpate/haptics/force_limits.h"
#include "palpate/rig/rig.h"

namespace palpate::haptics {

class ForcePermit {
 public:
  ForcePermit() = default;
  static ForcePermit of(const device::ArmFacts& arm, const rig::Rig& rig);
  // Of a computed arm that no driver hands over (lock-step, tests).
  static ForcePermit of_simulated_arm() {
    device::ArmFacts facts;
    facts.simulated = true;
    return of(facts, {});
  }

  bool given() const { return given_; }
  // Why it is not given and what to do about it, or what it is restricted to; one line, empty: nothing to tell.
  const std::string& words() const { return words_; }
  // The limits of an arm, lowered to what is permitted, and so that what is felt stays below them: a known weight may
  // have told that more is felt than is commanded.
  ForceLimits lowered(ForceLimits limits) const;
  // Whether the dead-man switch, where there is one, is among the pressed buttons (ArmSample::buttons).
  bool held(std::uint32_t buttons) const { return (buttons & wanted_buttons_) == wanted_buttons_; }

 private:
  bool given_ = false;
  double peak_n_ = 0.0;  // 0: as the limits have it
  double gain_ = 1.0;    // felt over commanded force, where it is above 1
  std::uint32_t wanted_buttons_ = 0;
  std::string words_ =
      "forces stay off: nobody has seen that this arm's forces go where they are commanded; run `palpate "
      "calibrate forces`";
};

}  // namespace palpate::haptics
