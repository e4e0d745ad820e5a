// What a person should know of the guests of a physics server: who has taken the forces away, and who has taken a
// loop with it. Called each 20 ms by one ordinary thread; it counts its looks and no time, so that a process
// that was stopped as a whole blames nobody.
#pragma once

#include <string>

#include "palpate/server/physics/physics_server.h"

namespace palpate::server::physics {

class GuestNews {
 public:
  struct Line {
    std::string text;   // empty: nothing new
    bool last = false;  // a loop does not come back: the server has to end
  };
  static constexpr int kTold = 25, kGivenUp = 100;  // looks
  // Of an arm that is silent or lost its driver tells itself, and sooner; this is for a driver that does not, as it
  // throws.
  static constexpr int kSilenceTold = 100;

  Line look(const PhysicsServer& server, bool haptic_loop_hangs);
  // Whether a loop stood still between the last two looks.
  bool hang() const { return hanging_ > 0 || standing_ > 0; }

 private:
  Line of_the_loops(const PhysicsServer& server, bool haptic_loop_hangs);

  bool failure_told_ = false, fault_told_ = false;
  device::ForceFault fault_ = device::ForceFault::none;
  int same_fault_ = 0, hanging_ = 0, standing_ = 0;
  std::uint64_t steps_ = 0;
};

}  // namespace palpate::server::physics
