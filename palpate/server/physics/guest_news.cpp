#include "palpate/server/physics/guest_news.h"

#include <fmt/format.h>

namespace palpate::server::physics {

GuestNews::Line GuestNews::look(const PhysicsServer& server, bool haptic_loop_hangs) {
  if (Line line = of_the_loops(server, haptic_loop_hangs); !line.text.empty()) return line;
  if (!failure_told_ && !server.trouble().empty()) {
    failure_told_ = fault_told_ = true;
    return {server.trouble()};
  }
  const haptics::HapticCondition condition = server.haptic().condition();
  if (condition.fault != fault_) same_fault_ = 0, fault_told_ = failure_told_;
  fault_ = condition.fault;
  // Of what does not heal the trip's line tells. It is left out where another trip came just before: who has taken the
  // forces for good is named here.
  const bool lost = fault_ == device::ForceFault::arm_lost;
  const bool for_good =
      lost || fault_ == device::ForceFault::law_failed || fault_ == device::ForceFault::arm_slow;
  const int told = lost || fault_ == device::ForceFault::arm_silent ? kSilenceTold : kTold;
  if (condition.culprit == haptics::Guest::none || !(device::heals(fault_) || for_good) || fault_told_ ||
      ++same_fault_ < told)
    return {};
  fault_told_ = true;
  return {fmt::format("forces are off: {}: {}", device::name_of(condition.fault),
                      server.haptic().name_of(condition.culprit))};
}

// The haptic loop by its watchdog, the physics loop by its steps.
GuestNews::Line GuestNews::of_the_loops(const PhysicsServer& server, bool haptic_loop_hangs) {
  const std::uint64_t steps = server.steps_ended();
  standing_ = steps == steps_ ? standing_ + 1 : 0;
  steps_ = steps;
  // The watchdog waits for a first tick to have ended: one that never does is seen here.
  hanging_ = haptic_loop_hangs || server.haptic().ticks_ended() == 0 ? hanging_ + 1 : 0;
  const auto words = [&](haptics::Guest guest, bool last) {
    const std::string who = server.haptic().name_of(guest);
    return fmt::format("{} does not come back{}", who.empty() ? "a loop" : who,
                       last ? "; the server ends" : "; forces are off");
  };
  const haptics::Guest busy = server.haptic().busy_with();
  if (hanging_ == kTold || hanging_ == kGivenUp)
    return {words(busy, hanging_ == kGivenUp), hanging_ == kGivenUp};
  if (standing_ == kTold || standing_ == kGivenUp)
    return {words(haptics::Guest::application, standing_ == kGivenUp), standing_ == kGivenUp};
  return {};
}

}  // namespace palpate::server::physics
