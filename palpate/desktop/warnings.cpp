#include "palpate/desktop/warnings.h"

#include <fmt/format.h>

namespace palpate::desktop {
namespace {

constexpr double kBlip_s = 0.12;  // of what a single sample may say; four pictures at 30 Hz
constexpr double kGone_s = 0.25;  // without its cause a warning stands so long, so that nothing flickers

using device::ForceFault;
using device::ForceState;

std::string forces_words(const device::ForceCondition& forces, const std::string& culprit, bool felt) {
  if (forces.fault == ForceFault::overspeed && !felt)
    return "Too fast: the force rests until the hand has been calm for half a second";
  if (forces.fault == ForceFault::overspeed)
    return "The hand was too fast and forces are off: they come back when it has been calm for half a second";
  if (forces.fault == ForceFault::arm_unchecked)
    return "Forces are off: nobody has checked this arm's; palpate calibrate forces";
  if (forces.fault == ForceFault::button_released) return "Forces are off: hold the stylus' button";
  std::string why = device::reason_text(forces);
  if (!culprit.empty()) why += ", " + culprit;
  if (!why.empty()) why = " (" + why + ")";
  if (forces.state == ForceState::degraded) return fmt::format("Forces are weakened{}", why);
  return fmt::format("Forces are off{}: R switches them on again, and begins from zero", why);
}

}  // namespace

void Warnings::judge(Trouble trouble, double now, bool wrong, double wait_s, std::string words) {
  One& one = all_[static_cast<std::size_t>(trouble)];
  if (wrong) {
    one.gone_since.reset();
    if (!one.since) one.since = now;
    one.words = std::move(words);
    if (now - *one.since >= wait_s) one.shown = true;
    return;
  }
  one.since.reset();
  if (!one.shown) return;
  if (!one.gone_since) one.gone_since = now;
  if (now - *one.gone_since >= kGone_s) one = One{};
}

void Warnings::look(double now, const Standing& c) {
  devices_ = c.devices;
  const bool physics = c.since_physics_s > kPhysicsSilent_s;
  judge(Trouble::physics, now, physics, 0.0,
        "The physics server does not answer: the game stands still. Start `palpate physics` again");
  // What the last states said is no news while none come.
  judge(Trouble::late, now, !physics && c.late_share > kLateShare, kBlip_s,
        fmt::format("States come too late for {:.0f} % of the pictures: what moves is drawn where it was",
                    100.0 * c.late_share));
  judge(Trouble::old, now, !physics && c.state_old, kBlip_s,
        "The physics server no longer has the states of these pictures: the camera is too slow");
  const bool failed = !c.failure.empty();
  const bool off = failed || (c.forces && c.forces->state == ForceState::safe),
             weak = c.forces && c.forces->state == ForceState::degraded;
  // A loop that stood still for a tick heals before anybody could read of it.
  judge(Trouble::forces, now, !physics && (off || weak), off ? 0.0 : kBlip_s,
        failed        ? "Forces are off: " + c.failure
        : off || weak ? forces_words(*c.forces, c.culprit, c.felt)
                      : std::string());
  judge(Trouble::refusal, now, !c.refusal.empty(), 0.0,
        fmt::format("The physics server refuses: {}", c.refusal));
}

std::vector<Warning> Warnings::shown() const {
  std::vector<Warning> list;
  for (const auto& words : devices_) list.push_back({Trouble::device, words});
  for (std::size_t i = 0; i < all_.size(); ++i)
    if (all_[i].shown) list.push_back({static_cast<Trouble>(i), all_[i].words});
  return list;
}

}  // namespace palpate::desktop
