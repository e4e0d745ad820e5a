#include "palpate/haptics/force_permit.h"

#include <fmt/format.h>

#include <algorithm>

namespace palpate::haptics {

ForcePermit ForcePermit::of(const device::ArmFacts& arm, const rig::Rig& rig) {
  ForcePermit permit;
  if (arm.simulated) {
    permit.given_ = true;
    permit.words_.clear();
    return permit;
  }
  constexpr const char* kRemedy = "run `palpate calibrate forces --arm URI --rig FILE`";
  if (!rig.forces) {
    permit.words_ = fmt::format(
        "forces stay off: nobody has seen that the forces of this arm go where they are commanded; {}",
        kRemedy);
    return permit;
  }
  if (arm.identity.empty()) {
    permit.words_ = "forces stay off: the arm's driver does not say which arm it is (ArmFacts::identity)";
    return permit;
  }
  if (const std::string change = rig::void_reason(rig, arm.identity); !change.empty()) {
    permit.words_ = fmt::format("forces stay off: since they were checked {}; {} again", change, kRemedy);
    return permit;
  }
  // Never so from a file, which is read with these bounds.
  if (!(rig.forces->peak > 0.0) || rig.forces->dead_man_button < 0 || rig.forces->dead_man_button > 32) {
    permit.words_ =
        fmt::format("forces stay off: their check allows a peak of {:g} N and wants button {}; {}",
                    rig.forces->peak, rig.forces->dead_man_button, kRemedy);
    return permit;
  }
  permit.given_ = true;
  permit.words_.clear();
  permit.gain_ = std::max(1.0, rig.forces->gain.value_or(1.0));
  // A weight tells one axis. The check tells nothing of how strong the axes of an arm are that states its place.
  const bool sized = rig.forces->gain && !arm.states_place;
  permit.peak_n_ = sized ? rig.forces->peak : std::min(rig.forces->peak, rig::kUnweighedPeak);
  if (!sized)
    permit.words_ = fmt::format(
        "forces stay below {:g} N: {}", permit.peak_n_,
        arm.states_place ? "whether all axes of an arm that states its place are equally strong no "
                           "check has told"
                         : "no known weight has told their size (palpate calibrate forces --weight-g)");
  if (const int button = rig.forces->dead_man_button; button > 0) {
    permit.wanted_buttons_ = 1u << static_cast<unsigned>(button - 1);
    permit.words_ += fmt::format("{}forces only while button {} of the stylus is held",
                                 permit.words_.empty() ? "" : "; ", button);
  }
  return permit;
}

ForceLimits ForcePermit::lowered(ForceLimits limits) const {
  if (peak_n_ <= 0.0) return limits;
  limits.peak_n = std::min(limits.peak_n, peak_n_);
  limits.peak_n /= gain_;
  limits.continuous_n = std::min(limits.continuous_n / gain_, limits.peak_n);
  return limits;
}

}  // namespace palpate::haptics
